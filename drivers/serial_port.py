"""Which serial port a device is on, as its lab says, and what to say when it does not work.

Configuration that every device on a serial line takes: `port` (/dev/ttyUSB0, COM3), `baud`,
`bits`, `parity` (N, E or O), `stop_bits`.
"""

import errno
from dataclasses import dataclass
from typing import Any

from .driver import Place

OPTIONS = ("port", "baud", "bits", "parity", "stop_bits")
IN_USE = {errno.EAGAIN, errno.EACCES, errno.EBUSY, errno.EWOULDBLOCK}


@dataclass(frozen=True, slots=True)
class SerialPort:
    """A port by its name, how bytes are framed on it, and whose it is."""

    device: str
    name: str
    framing: dict[str, Any]

    def __str__(self) -> str:
        bits, parity, stop = (self.framing[name] for name in ("bytesize", "parity", "stopbits"))
        return f"{self.name} ({self.framing['baudrate']} baud, {bits}{parity}{stop})"

    def said(self, asked: str, answer: str) -> str:
        """Who was asked what, and what was answered: the beginning of a sentence."""
        return f"{self.device} on {self} was asked {asked!r} and answered {answer[:60]!r}"

    def no_answer(self, asked: str, heard: list[str], language: str) -> str:
        """A question that was not answered: what was heard instead, and what now."""
        if not heard:
            return (
                f"{self.device} on {self} was asked {asked!r} and was silent: is it on, is the cable "
                "in, is this its port and its baud rate?"
            )
        said = f"{self.said(asked, heard[-1])}, which is not {language}:"
        if "\\x" in "".join(heard):
            return f"{said} its baud rate, bits or parity may be others, or another device is there"
        return f"{said} another device may be there, or its menu is set to another language"

    def gone(self, fault: object) -> OSError:
        """The cable was pulled, or the adapter has left."""
        return OSError(
            f"{self.device}: {self.name} is gone ({fault}); plug it in, the next action opens it again"
        )

    def why_not(self, fault: Exception) -> OSError:
        """The port cannot be opened."""
        number = getattr(fault, "errno", None)
        if number == errno.ENOENT or "FileNotFoundError" in str(fault):
            from serial.tools.list_ports import comports

            there = ", ".join(sorted(found.device for found in comports())) or "none"
            return OSError(f"there is no port {self.name}; ports of this machine: {there}")
        if number == errno.EACCES and "lock" not in str(fault):
            return OSError(
                f"{self.name} may not be used by you: `sudo usermod -aG dialout $USER`, log in anew"
            )
        if number in IN_USE or "PermissionError" in str(fault):
            return OSError(
                f"{self.name} is in use by another program: end that (`fuser {self.name}` names it)"
            )
        return OSError(f"{self.name} cannot be opened as a serial port: {fault}")


def read_port(place: Place, options: tuple[str, ...] = ()) -> SerialPort:
    """The port of a device's configuration; `options` are what else the driver takes.

    Raises ValueError for what is unknown, missing, or no rate, framing or parity.
    """
    from serial import Serial

    config, known = place.config, (*OPTIONS, *options)
    if unknown := sorted(set(config) - set(known)):
        raise ValueError(f"config has no {', '.join(unknown)}; it has: {', '.join(known)}")
    if not isinstance(config.get("port"), str):
        raise ValueError("config has no port: say where it is plugged in, as in port: /dev/ttyUSB0")
    framing = {
        "baudrate": config.get("baud", 9600),
        "bytesize": config.get("bits", 8),
        "parity": config.get("parity", "N"),
        "stopbits": config.get("stop_bits", 1),
    }
    try:
        Serial(**framing)  # without a port it opens none
    except ValueError as fault:
        raise ValueError(f"config: baud, bits, parity or stop_bits will not do: {fault}") from fault
    return SerialPort(place.device, config["port"], framing)
