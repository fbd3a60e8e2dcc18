"""What follows a line so that a garbled one is noticed: `@01P?*5C`.

CRC names and check values: https://reveng.sourceforge.io/crc-catalogue/16.htm (crc16 is Modbus's).
"""

from collections.abc import Callable
from functools import reduce
from operator import xor
from typing import Literal

from pydantic import Field, field_validator

from ...schemas.model import Model


def _crc_reflected(data: bytes) -> int:
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
    return crc


def _crc(data: bytes, start: int) -> int:
    crc = start
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ (0x1021 if crc & 0x8000 else 0)) & 0xFFFF
    return crc


WAYS: dict[str, Callable[[bytes], int]] = {
    "xor": lambda data: reduce(xor, data, 0),
    "sum": lambda data: sum(data) % 256,
    "complement": lambda data: -sum(data) % 256,
    "crc16": _crc_reflected,
    "ccitt": lambda data: _crc(data, 0xFFFF),
    "xmodem": lambda data: _crc(data, 0),
}


class Checksum(Model):
    """`of` which kind; the text `after` which it stands; its `form`; how many first signs it `skips`."""

    of: Literal["xor", "sum", "complement", "crc16", "ccitt", "xmodem"]
    after: str = ""
    form: str = ""
    skips: int = Field(default=0, ge=0)
    answers: bool = True

    @field_validator("form")
    @classmethod
    def _is_a_form(cls, value: str) -> str:
        if value in ("", "c", "02X", "02x", "03d", "04X", "04x", "05d"):
            return value
        raise ValueError(f"{value!r} is no form of a checksum: 02X, 02x, 03d, 04X, 04x, 05d, or c")

    def added(self, line: bytes) -> bytes:
        """The line as it is sent."""
        return line + self.after.encode("latin-1") + self._of(line)

    def taken(self, line: bytes) -> bytes | None:
        """The line that was sent; None if the checksum is not its."""
        size = len(self.after) + len(self._of(b""))
        kept = line[:-size]
        return kept if self.added(kept).upper() == line.upper() else None

    def _of(self, line: bytes) -> bytes:
        number = WAYS[self.of](line[self.skips :])
        wide = self.of in ("crc16", "ccitt", "xmodem")
        return format(number, self.form or ("04X" if wide else "02X")).encode("latin-1")
