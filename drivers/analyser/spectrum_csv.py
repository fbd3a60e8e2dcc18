"""Check that a CSV is a complete spectrum: every line readable, the last ended, no channel missing."""

import math

LEAST_CHANNELS = 100
HEADER_LINES = 50


class Incomplete(Exception):
    """Not a complete spectrum; the text says where it ends or what it holds."""


def channels_of(data: bytes) -> int:
    """How many channels a CSV holds; raises Incomplete if it is cut off or not a spectrum.

    Two columns, wavelength and intensity, after at most 50 lines of text; commas, semicolons or
    tabs. A last line without a line end may be half a number: it counts only if it has as many
    decimals as the line before.
    """
    if not data:
        raise Incomplete("it is still empty")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise Incomplete("it is not text") from None
    lines = text.split("\n")
    if lines[-1] and (len(lines) < 2 or _decimals(lines[-1]) != _decimals(lines[-2])):
        raise Incomplete(f"it ends within line {len(lines)}")
    first = next((n for n, line in enumerate(lines[:HEADER_LINES]) if _pair(line)), None)
    if first is None:
        raise Incomplete(f"its first {HEADER_LINES} lines contain no wavelength and intensity")
    count = 0
    for number, line in enumerate(lines[first:], first + 1):
        if line.strip():
            if _pair(line) is None:
                raise Incomplete(
                    f"line {number} is not a wavelength and an intensity: {line.strip()[:40]!r}"
                )
            count += 1
    if count < LEAST_CHANNELS:
        raise Incomplete(f"it has only {count} channels")
    return count


def _pair(line: str) -> tuple[float, float] | None:
    parts = line.replace(";", ",").replace("\t", ",").split(",")
    if len(parts) < 2:
        return None
    try:
        wavelength, intensity = float(parts[0]), float(parts[1])
    except ValueError:
        return None
    return (wavelength, intensity) if math.isfinite(wavelength) else None


def _decimals(line: str) -> tuple[int, ...]:
    """Digits after the decimal point in each field of a line; -1 if there is none."""
    fields = line.strip().replace(";", ",").replace("\t", ",").split(",")
    return tuple(len(f.partition(".")[2]) if "." in f else -1 for f in fields)
