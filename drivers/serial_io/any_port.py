"""A controller's serial port, or a program behind a socket: opened, and missed, with a reason."""

from typing import Any

from .open_port import READ_S, WRITE_S, open_exclusively


def lost_words(name: str, fault: Exception) -> str:
    """Why nothing can be sent any more, with the system's message if that adds anything."""
    told = str(fault)
    usual = ("readiness to read", "Input/output error", "Bad file descriptor")
    detail = "" if any(words in told for words in usual) else f" ({told})"
    return f"{name} was unplugged or is gone{detail}"


def open_port(name: str, baud: int) -> Any:
    """The open port, locked for others; raises OSError with the reason."""
    if not name.startswith(("socket://", "ws://")):
        return open_exclusively(name, baudrate=baud)
    try:
        if name.startswith("ws://"):
            from .websocket_port import WebSocketPort

            return WebSocketPort(name)
        import serial

        return serial.serial_for_url(name, timeout=READ_S, write_timeout=WRITE_S)
    except Exception as fault:  # whatever pyserial, a socket or the handshake raises
        raise OSError(
            f"{name} cannot be reached: {fault}; is the program behind it running?"
        ) from fault
