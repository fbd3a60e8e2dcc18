"""Where an instrument is, as a lab writes it: `host:port`, `udp://...`, `ws://...`, a serial port, VISA."""

import re
from dataclasses import dataclass
from typing import ClassVar, Literal
from urllib.parse import urlsplit

from pydantic import Field, field_validator

from ...schemas.model import Model

Kind = Literal["tcp", "udp", "ws", "serial", "visa"]
SOCKET = re.compile(r"TCPIP\d*::(?P<host>[^:]+|\[[^\]]+\])::(?P<port>\d+)::SOCKET", re.I)
ADDRESS = re.compile(
    r"(?:(?P<kind>tcp|udp|telnet)://)?(?P<host>[A-Za-z0-9_.-]+|\[[^\]]+\]):(?P<port>\d+)/?", re.I
)
SERIAL = re.compile(r"ASRL(?P<name>[^:]+)(?:::INSTR)?|(?P<plain>/.+|COM\d+)", re.I)
WEBSOCKET = re.compile(r"wss?://[^\s/]+(/\S*)?", re.I)
VISA = re.compile(r"[A-Z]+\d*::", re.I)


@dataclass(frozen=True, slots=True)
class Resource:
    """One of five kinds of address; `name` is the serial port, the VISA resource or the whole address."""

    kind: Kind
    written: str
    host: str = ""
    port: int = 0
    name: str = ""

    def __str__(self) -> str:
        return self.written


def read_resource(text: str) -> Resource:
    """The address that a text names; raises ValueError."""
    plain = text.strip()
    found = SOCKET.fullmatch(plain) or ADDRESS.fullmatch(plain)
    if found is not None:
        port = int(found["port"])
        if not 0 < port < 65536:
            raise ValueError(f"{text!r}: {port} is no port; a port is a number from 1 to 65535")
        udp = found.groupdict().get("kind") or ""
        return Resource(
            "udp" if udp.lower() == "udp" else "tcp", plain, found["host"].strip("[]"), port
        )
    if WEBSOCKET.fullmatch(plain):
        return Resource("ws", plain, name=plain)
    if found := SERIAL.fullmatch(plain):
        name = found["plain"] or found["name"]
        return Resource("serial", plain, name=f"COM{name}" if name.isdigit() else name)
    if is_visa(plain):
        return Resource("visa", plain, name=plain)
    raise ValueError(
        f"{text!r} is no address: write host:port, udp://host:port, ws://host:port/path, a serial port "
        f"(/dev/ttyUSB0, COM3) or a VISA resource (TCPIP::10.0.0.5::INSTR, USB0::..., GPIB0::22::INSTR)"
    )


def is_visa(text: str) -> bool:
    """Whether only VISA reaches this address."""
    plain = text.strip()
    return VISA.match(plain) is not None and not (
        SOCKET.fullmatch(plain) or SERIAL.fullmatch(plain)
    )


class Wire(Model):
    """Where an instrument is; if that is a serial port, how it speaks there, and with whom."""

    kinds: ClassVar[tuple[Kind, ...]] = ("tcp", "udp", "serial", "visa")

    resource: str
    baud: int = Field(default=9600, gt=0)
    bits: Literal[5, 6, 7, 8] = 8
    parity: Literal["N", "E", "O"] = "N"
    stop_bits: Literal[1, 2] = 1
    shared: bool = False

    @field_validator("resource")
    @classmethod
    def _is_reached(cls, value: str) -> str:
        kind = read_resource(value).kind
        if kind == "ws" and kind not in cls.kinds:
            raise ValueError(f"{value!r} is a WebSocket's address, which `driver: text` speaks to")
        if kind not in cls.kinds:
            raise ValueError(f"{value!r} is neither host:port nor a serial port")
        return value


class Served(Model):
    """Where a server is."""

    schemes: ClassVar[tuple[str, ...]]

    url: str

    @field_validator("url")
    @classmethod
    def _is_an_address(cls, value: str) -> str:
        if value.startswith(cls.schemes) and urlsplit(value).hostname:
            return value.rstrip("/")
        raise ValueError(f"{value!r} is no address such as {cls.schemes[0]}10.0.0.9:8080")
