"""Judge a CSV: a whole spectrum, one that is cut off, or no spectrum at all."""

import math
from dataclasses import dataclass
from hashlib import sha256
from itertools import pairwise

LEAST_CHANNELS = 100
HEADER_LINES = 50
USUAL_NM = 1200.0
"""The limit of silicon: beyond it, or from 0 or 1 on, steps of exactly 1 are channel numbers."""
EQUAL = 0.5
"""Part of the channels that must have wavelengths of their own; spectrometers overlap a little."""


class Incomplete(Exception):
    """Not a complete spectrum yet; the text says where it ends or what it holds."""


class NoSpectrum(Incomplete):
    """Complete, and not a spectrum; the text says what it is."""


@dataclass(frozen=True, slots=True)
class Judged:
    """A spectrum as it was judged: how many channels, the SHA-256 of its numbers alone, and whether
    its last line has an end."""

    channels: int
    numbers: str
    ended: bool


def judged(data: bytes) -> Judged:
    """The spectrum in a CSV; raises Incomplete if it is cut off, NoSpectrum if it is none.

    Two columns, wavelength (nm) and intensity, after at most 50 lines of text; commas, semicolons
    or tabs. A last line without a line end may be half a number: it counts only if it has as many
    decimals as the line before.
    """
    if not data:
        raise Incomplete("it is still empty")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise NoSpectrum("it is not text") from None
    lines = text.split("\n")
    first = next((n for n, line in enumerate(lines[:HEADER_LINES]) if _pair(line)), None)
    if first is None:
        raise NoSpectrum(f"its first {HEADER_LINES} lines contain no wavelength and intensity")
    if lines[-1] and (len(lines) < 2 or _decimals(lines[-1]) != _decimals(lines[-2])):
        raise Incomplete(f"it ends within line {len(lines)}")
    pairs = []
    for number, line in enumerate(lines[first:], first + 1):
        if line.strip():
            pair = _pair(line)
            if pair is None:
                raise NoSpectrum(
                    f"line {number} is not a wavelength and an intensity: {line.strip()[:40]!r}"
                )
            pairs.append(pair)
    if len(pairs) < LEAST_CHANNELS:
        raise NoSpectrum(f"it has only {len(pairs)} channels")
    wrong = _fault_in_header(lines[:first]) or _fault_in(pairs)
    if wrong is not None:
        raise NoSpectrum(wrong)
    numbers = sha256(repr(pairs).encode()).hexdigest()
    return Judged(len(pairs), numbers, not lines[-1])


def _fault_in_header(lines: list[str]) -> str | None:
    """The names of its columns, where the last line before the numbers has some."""
    names = [name.strip(' "\r').lower() for name in _fields(lines[-1])[:2]] if lines else []
    if names and names[0].startswith(("pixel", "channel", "index")):
        return f"its columns are {', '.join(names)}: it has no wavelengths"
    return None


def _fault_in(pairs: list[tuple[float, float]]) -> str | None:
    wavelengths = [pair[0] for pair in pairs]
    different = len(set(wavelengths))
    if different <= EQUAL * len(pairs):
        return f"its {len(pairs)} channels have only {different} different wavelengths"
    steps = {after - before for before, after in pairwise(wavelengths)}
    if steps == {1.0} and (wavelengths[0] in (0.0, 1.0) or wavelengths[-1] > USUAL_NM):
        return "its first column counts channels (0, 1, 2, ...): it has no wavelengths"
    light = {pair[1] for pair in pairs if math.isfinite(pair[1])}
    if len(light) <= 1:
        same = f"{light.pop():g}" if light else "no number"
        return f"every intensity is {same}: the detector was not read out"
    return None


def _pair(line: str) -> tuple[float, float] | None:
    parts = _fields(line)
    if len(parts) < 2:
        return None
    try:
        wavelength, intensity = float(parts[0]), float(parts[1])
    except ValueError:
        return None
    return (wavelength, intensity) if math.isfinite(wavelength) else None


def _fields(line: str) -> list[str]:
    return line.replace(";", ",").replace("\t", ",").split(",")


def _decimals(line: str) -> tuple[int, ...]:
    """Digits after the decimal point in each field of a line; -1 if there is none."""
    return tuple(len(f.partition(".")[2]) if "." in f else -1 for f in _fields(line.strip()))
