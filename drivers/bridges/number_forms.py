"""Numbers that are not written in decimal: as bytes (`>f4`, `<i2`, `u1`, `>bcd3`), as a mantissa and a power.

Of bytes, `<` is the lowest first, `>` the highest; in `><` and `<>` these are the bytes of a word of two, and
the words lie the other way round; `i` and `u` are whole numbers with and without a sign,
`f` is IEEE 754, of `bcd` each byte is two decimal digits; then how many they are. With `base: 16` they are
written in hexadecimal. `mantissa: 4` is 1.234E+05 as `1234+5`, and with `power: -20` as `123425`.
"""

import contextlib
import functools
import math
import re
import struct
from collections.abc import Mapping
from typing import Any

KIND = re.compile(r"(><|<>|[<>]?)(?:(i|u|bcd)([1-8])|f([248]))")
FLOATS = {2: "e", 4: "f", 8: "d"}
FORMS = ("bytes", "mantissa")
Schema = Mapping[str, Any]


def decimals(text: str, schema: Schema) -> list[str]:
    """The numbers that are written so, each in decimal; raises ValueError."""
    return _of_mantissa(text.strip(), schema) if "mantissa" in schema else _of_bytes(text, schema)


def formed(number: float, schema: Schema) -> str:
    """The number as the instrument takes it; raises ValueError if it cannot be written so."""
    if "mantissa" not in schema:
        return number_bytes(number, str(schema["bytes"]), in_hex=schema.get("base") == 16)
    if not number > 0:
        raise ValueError(f"{number:g} has no such mantissa")
    mantissa, exponent = f"{number:.{int(schema['mantissa']) - 1}e}".split("e")
    power = int(exponent) - int(schema.get("power", 0))
    if "power" in schema and not 0 <= power <= 99:
        raise ValueError(f"{number:g} does not go into two digits of its power")
    return mantissa.replace(".", "") + (f"{power:02d}" if "power" in schema else f"{power:+d}")


def number_bytes(number: float, kind: str, *, in_hex: bool = False) -> str:
    """A sign for each byte; raises ValueError if it does not go into so many."""
    order, sign, size, floats = _parts(kind)
    try:
        if floats:
            data = struct.pack(order + FLOATS[size], number)
        else:
            whole = int(f"{round(number)}", 16 if sign == "bcd" else 10)
            data = whole.to_bytes(size, "big" if order == ">" else "little", signed=sign == "i")
    except (OverflowError, struct.error):
        raise ValueError(f"{number:g} does not go into {kind}") from None
    data = _turned(data, kind)
    return data.hex().upper() if in_hex else data.decode("latin-1")


def size_of(kind: str) -> int:
    """How many bytes it has; raises ValueError if it is none."""
    return _parts(kind)[2]


def form_faults(schema: Schema) -> list[tuple[str, str]]:
    """(key, message) of what is wrong in how it is said."""
    try:
        size_of(str(schema.get("bytes", "u1")))
    except ValueError as fault:
        return [("bytes", str(fault))]
    most = schema.get("mantissa", 1)
    if not isinstance(most, int) or not 0 < most < 18:
        return [("mantissa", "it is how many digits stand before the power")]
    return []


def _of_bytes(text: str, schema: Schema) -> list[str]:
    kind = str(schema["bytes"])
    try:
        data = bytes.fromhex(text) if schema.get("base") == 16 else text.encode("latin-1")
    except ValueError:
        raise ValueError(f"{text!r} is not {kind} in hexadecimal") from None
    size = size_of(kind)
    if not data or len(data) % size:
        raise ValueError(f"{len(data)} bytes ({data[:16].hex(' ')}) are no {kind}")
    return [_read(_turned(data[at : at + size], kind), kind) for at in range(0, len(data), size)]


def _of_mantissa(text: str, schema: Schema) -> list[str]:
    digits = int(schema["mantissa"])
    found = re.fullmatch(rf"([+-]?\d{{{digits}}})([+-]?\d+)", text)
    if found is None:
        raise ValueError(f"{text!r} is no number of {digits} digits and a power")
    return [f"{found[1]}e{int(found[2]) + int(schema.get('power', 0)) - digits + 1}"]


def _turned(data: bytes, kind: str) -> bytes:
    """With its words the other way round, if they lie otherwise than their bytes."""
    if kind[:2] not in ("><", "<>"):
        return data
    return b"".join(data[at : at + 2] for at in range(len(data) - 2, -1, -2))


def _read(data: bytes, kind: str) -> str:
    order, sign, size, floats = _parts(kind)
    if sign == "bcd":
        digits = (data if order == ">" else data[::-1]).hex()
        if not digits.isdigit():
            raise ValueError(f"{data.hex(' ')} is no {kind}: each of its digits is 0 to 9")
        return str(int(digits))
    if not floats:
        return str(int.from_bytes(data, "big" if order == ">" else "little", signed=sign == "i"))
    form = order + FLOATS[size]
    (number,) = struct.unpack(form, data)
    return fewest_digits(number, form)


def fewest_digits(number: float, form: str) -> str:
    """The shortest number that is the same in these bytes: 1.1 of four is not 1.100000023841858."""
    if not math.isfinite(number) or form[-1] == "d":
        return repr(number)
    data = struct.pack(form, number)
    for digits in range(
        3 if form[-1] == "e" else 6, 10
    ):  # what is meant has no more than the first
        text = f"{number:.{digits}g}"
        with contextlib.suppress(OverflowError):  # rounded up, it no longer goes into so few bytes
            if struct.pack(form, float(text)) == data:
                return text
    return repr(number)


@functools.cache
def _parts(kind: str) -> tuple[str, str, int, bool]:
    """Byte order, whether it has a sign, size, whether it is a float."""
    found = KIND.fullmatch(kind)
    if found is None:
        raise ValueError(f"{kind!r} is no number type such as >f4, <i2, u1")
    size = int(found[3] or found[4])
    if found[1][1:] and size % 4:
        raise ValueError(f"{kind!r} has no words that could be turned: it has {size} bytes")
    return found[1][:1] or "<", found[2] or "i", size, found[4] is not None
