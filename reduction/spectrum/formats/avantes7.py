"""Avantes AvaSoft 6 and 7 (.roh, .trm, .abs and their kin): 32-bit floats throughout, letters too.

A file with as many floats again for its reference and its dark spectrum has these taken apart.
"""

import numpy as np

from ..fault import Unreadable
from ..readout import Readout

NAME = "an AvaSoft 7 file"
VERSIONS = {
    60.0: (1, 15, 19),
    70.0: (74, 79, 100),
}  # of floats: where the polynomial, pixels, data begin
COEFFICIENTS, MOST_AFTER = 5, 3
PLACE, MOST_PIXELS = 4096, 20_000


def begins(raw: bytes) -> bool:
    """Its first float is a version, and as many counts follow as its pixels."""
    if len(raw) < 4 or raw[:2] != b"\0\0" or raw[2:4] not in (b"\x70\x42", b"\x8c\x42"):
        return False
    numbers = _numbers(raw)
    pixels = VERSIONS[float(numbers[0])][1]
    ends = numbers[pixels : pixels + 2]
    return len(ends) == 2 and bool(0 <= ends[0] < ends[1] < MOST_PIXELS)


def read(raw: bytes) -> Readout:
    numbers = _numbers(raw)
    polynomial, pixels, begin = VERSIONS[float(numbers[0])]
    first, last = (int(one) for one in numbers[pixels : pixels + 2])
    n, there = last - first + 1, len(numbers) - begin
    times = next((k for k in (1, 3) if 0 <= there - k * n <= MOST_AFTER), None)
    if times is None:
        raise Unreadable(
            f"this is {NAME} of {n} pixels with {there} numbers after its heading: is it complete?"
        )
    pixel = np.arange(first, last + 1, dtype=np.float64)
    axis = np.polynomial.polynomial.polyval(pixel, numbers[polynomial : polynomial + COEFFICIENTS])
    counts = numbers[begin : begin + times * n].reshape(n, times).T
    notes = ()
    if times == 3 and counts[2].any():
        counts, notes = (
            counts[:1] - counts[2],
            ("the dark spectrum that the file holds was subtracted",),
        )
    return Readout(np.asarray(axis, np.float64), counts[:1], "nm", notes)


def _numbers(raw: bytes) -> np.ndarray:
    return np.frombuffer(raw, "<f4", count=len(raw) // 4).astype(np.float64)
