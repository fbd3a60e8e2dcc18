"""The serial port of a device, as configured in its lab, and the messages for when it fails.

Configuration of every device on a serial line: `port` (/dev/ttyUSB0, COM3), `baud`, `bits`,
`parity` (N, E or O), `stop_bits`.
"""

from dataclasses import dataclass
from typing import Any

from ..driver import Misfit, Place, check_keys
from .open_port import open_exclusively

OPTIONS = ("port", "baud", "bits", "parity", "stop_bits")


@dataclass(frozen=True, slots=True)
class SerialPort:
    """A port's name, its framing, and its device."""

    device: str
    name: str
    framing: dict[str, Any]

    def __str__(self) -> str:
        bits, parity, stop = (self.framing[name] for name in ("bytesize", "parity", "stopbits"))
        return f"{self.name} ({self.framing['baudrate']} baud, {bits}{parity}{stop})"

    def asked_and_answered(self, asked: str, answer: str) -> str:
        """The command and its answer, as the beginning of a message."""
        return f"{self.device} on {self} was sent {asked!r} and answered {answer[:60]!r}"

    def no_answer(self, asked: str, heard: list[str], language: str) -> str:
        """The message for a missing answer: what came instead, and what to do."""
        if not heard:
            return (
                f"{self.device} on {self} was sent {asked!r} and was silent: is it on, is the cable "
                "plugged in, are its port and baud rate correct?"
            )
        start = f"{self.asked_and_answered(asked, heard[-1])}, which is not {language}:"
        if "\\x" in "".join(heard):
            return f"{start} its baud rate, bits or parity may be different, or another device is there"
        return f"{start} another device may be there, or its menu is set to another language"

    def opened(self, *, rtscts: bool = False, xonxoff: bool = False) -> Any:
        """The open port, locked for others; raises OSError with the reason."""
        return open_exclusively(self.name, rtscts=rtscts, xonxoff=xonxoff, **self.framing)

    def unplugged(self, fault: object) -> OSError:
        """The error for a pulled cable or a missing adapter."""
        return OSError(
            f"{self.device}: {self.name} is gone ({fault}); plug it in, the next action reopens it"
        )


def read_port(place: Place, options: tuple[str, ...] = ()) -> SerialPort:
    """The port in a device's configuration; `options` are the driver's other keys.

    Raises ValueError for an unknown or missing key, or an invalid rate, framing or parity.
    """
    from serial import Serial

    config = place.config
    check_keys((*OPTIONS, *options), config)
    if not isinstance(config.get("port"), str):
        raise ValueError(
            "config has no port: give the port that it is plugged into, such as port: /dev/ttyUSB0"
        )
    framing = {
        "baudrate": config.get("baud", 9600),
        "bytesize": config.get("bits", 8),
        "parity": config.get("parity", "N"),
        "stopbits": config.get("stop_bits", 1),
    }
    for key, (name, value) in zip(OPTIONS[1:], framing.items(), strict=True):
        try:
            Serial(**{name: value})  # without a port it opens none
        except ValueError as fault:
            raise Misfit(
                f"config: {key} is {value!r}, which will not do: {fault}", (key,)
            ) from fault
    return SerialPort(place.device, config["port"], framing)
