"""A GRBL controller's serial port, or a program behind a socket: opened, and missed, with a reason."""

import errno
from pathlib import Path
from typing import Any

from ..serial_io.open_port import READ_S, WRITE_S


def gone(name: str, fault: Exception) -> str:
    """Why nothing can be sent any more, with the system's message if that adds anything."""
    told = str(fault)
    usual = ("readiness to read", "Input/output error", "Bad file descriptor")
    detail = "" if any(words in told for words in usual) else f" ({told})"
    return f"{name} was unplugged or is gone{detail}"


def open_port(name: str, baud: int) -> Any:
    """The open port, locked for others; raises OSError with the reason."""
    import serial

    if not name.startswith("socket://"):
        return _opened(name, baud)
    try:
        return serial.serial_for_url(name, timeout=READ_S, write_timeout=WRITE_S)
    except (OSError, ValueError) as fault:
        raise OSError(
            f"{name} cannot be reached: {fault}; is the program behind it running?"
        ) from fault


def _opened(name: str, baud: int) -> Any:
    import serial

    try:
        return serial.Serial(name, baud, timeout=READ_S, write_timeout=WRITE_S, exclusive=True)
    except serial.SerialException as fault:
        raise OSError(_words(name, fault.errno, str(fault))) from fault
    except (OSError, ValueError) as fault:
        raise OSError(f"{name} cannot be opened at {baud} baud: {fault}") from fault


def _words(name: str, number: int | None, said: str) -> str:
    if number == errno.ENOENT or (number is None and "FileNotFoundError" in said):
        return f"there is no port {name}: is the cable plugged in? {_others()}"
    if number == errno.EACCES and not _is_windows_name(name):
        return (
            f"this user may not open {name}: `sudo usermod -aG dialout $USER` allows it "
            f"after the next login"
        )
    if number in (errno.EAGAIN, errno.EBUSY, errno.EWOULDBLOCK) or "PermissionError" in said:
        return f"{name} is in use by another program: close it there; only one program at a time can use it"
    if number in (errno.ENOTTY, errno.EINVAL) or (number is None and "configure" in said):
        return f"{name} is not a serial port ({said}). {_others()}"
    return f"{name} cannot be opened: {said}"


def _is_windows_name(name: str) -> bool:
    return name.upper().startswith("COM") and not Path(name).exists()


def _others() -> str:
    """The available ports, so that the right one can be copied from the message."""
    from serial.tools.list_ports import comports

    found = [f"{port.device} ({port.description})" for port in comports()]
    return f"Available: {', '.join(found)}" if found else "This computer has no serial port now"
