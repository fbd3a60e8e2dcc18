"""What follows a line so that a garbled one is noticed: `@01P?*5C`.

CRC names and check values: https://reveng.sourceforge.io/crc-catalogue/16.htm (crc16 is Modbus's);
Fletcher's sum modulo 256 (RFC 1145), as u-blox and MicroStrain have it.
"""

from collections.abc import Callable
from functools import reduce
from itertools import accumulate
from operator import xor
from typing import Literal

from pydantic import Field, field_validator, model_validator

from ...schemas.model import Model
from .number_forms import number_bytes, size_of


class Crc(Model):
    """A cyclic redundancy check as catalogues describe it: `bits` wide, `reflected` in and out."""

    bits: Literal[8, 16, 24, 32] = 16
    polynomial: int = Field(gt=0)
    start: int = Field(default=0, ge=0)
    reflected: bool = False
    final: int = Field(default=0, ge=0)

    def of(self, data: bytes) -> int:
        """The check of these bytes."""
        crc, whole = self.start, (1 << self.bits) - 1
        for byte in data:
            crc ^= (_mirrored(byte, 8) if self.reflected else byte) << self.bits - 8
            for _ in range(8):
                crc = (crc << 1 ^ (self.polynomial if crc >> self.bits - 1 else 0)) & whole
        return (_mirrored(crc, self.bits) if self.reflected else crc) ^ self.final


def _mirrored(number: int, bits: int) -> int:
    return int(format(number, f"0{bits}b")[::-1], 2)


WAYS: dict[str, Callable[[bytes], int]] = {
    "xor": lambda data: reduce(xor, data, 0),
    "sum": sum,
    "inverted": lambda data: ~sum(data),
    "complement": lambda data: -sum(data),
    "crc16": Crc(polynomial=0x8005, start=0xFFFF, reflected=True).of,
    "ccitt": Crc(polynomial=0x1021, start=0xFFFF).of,
    "xmodem": Crc(polynomial=0x1021).of,
    "fletcher": lambda data: sum(data) % 256 << 8 | sum(accumulate(data)) % 256,
}
WIDE = ("crc16", "ccitt", "xmodem", "fletcher")
"""Those of 16 bits."""
FORMS = {"02X": 8, "02x": 8, "03d": 8, "04X": 16, "04x": 16, "05d": 16, "08X": 32, "08x": 32}
BINARY = {"c": "u1", "<u2": "<u2", ">u2": ">u2", "<u4": "<u4", ">u4": ">u4"}
"""Form -> how many bits of it are written; those of its bytes."""


class Checksum(Model):
    """`of` which kind; the text `after` which it stands; its `form`; how many first signs it `skips`.

    With `first` it stands before the line.
    """

    of: (
        Literal["xor", "sum", "inverted", "complement", "crc16", "ccitt", "xmodem", "fletcher"]
        | Crc
    )
    after: str = ""
    form: str = ""
    skips: int = Field(default=0, ge=0)
    first: bool = False
    answers: bool = True

    @field_validator("form")
    @classmethod
    def _is_a_form(cls, value: str) -> str:
        if value in ("", *FORMS, *BINARY):
            return value
        raise ValueError(
            f"{value!r} is no form of a checksum: {', '.join(FORMS)}, {', '.join(BINARY)}"
        )

    @model_validator(mode="after")
    def _fits(self) -> "Checksum":
        if self._bits < self._least:
            raise ValueError(f"{self._least} bits do not go into {self.form}")
        return self

    @property
    def _least(self) -> int:
        if isinstance(self.of, Crc):
            return self.of.bits
        return 16 if self.of in WIDE else 8

    @property
    def _bits(self) -> int:
        """How many are written; of a sum as many as its form has."""
        if self.form in BINARY:
            return 8 * size_of(BINARY[self.form])
        return FORMS.get(self.form, self._least)

    @property
    def size(self) -> int:
        """How many signs it adds to a line."""
        return len(self.added(b""))

    def added(self, line: bytes) -> bytes:
        """The line as it is sent."""
        check, after = self._of(line), self.after.encode("latin-1")
        return check + after + line if self.first else line + after + check

    def taken(self, line: bytes) -> bytes | None:
        """The line that was sent; None if the checksum is not its."""
        kept = line[self.size :] if self.first else line[: -self.size]
        right = self.added(kept)
        if self.form not in BINARY:
            line, right = line.upper(), right.upper()
        return kept if line == right else None

    def _of(self, line: bytes) -> bytes:
        counted = line[self.skips :]
        number = self.of.of(counted) if isinstance(self.of, Crc) else WAYS[self.of](counted)
        number &= (1 << self._bits) - 1
        if self.form in BINARY:
            return number_bytes(number, BINARY[self.form]).encode("latin-1")
        return format(number, self.form or f"0{self._bits // 4}X").encode("latin-1")
