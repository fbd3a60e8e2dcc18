"""G-code of moves as steps of a gantry: G0 and G1 in mm or inches, absolute or relative, and $H.

NIST, *RS274/NGC Interpreter*, NISTIR 6556 (2000). Everything else is rejected, and nothing rejected
is sent on: a device that is controlled by its contract gets no raw lines.
"""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

WORD = re.compile(r"\s*([A-Za-z])\s*([+-]?(?:\d+\.?\d*|\.\d+))")
COMMENT = re.compile(r"\([^)]*\)|;.*")
AXES = "XYZ"
MOVES, MODES, PLANES = (0.0, 1.0), (20.0, 21.0, 90.0, 91.0), (17.0, 54.0, 94.0)
INCH_MM = 25.4


class GcodeFault(ValueError):
    """A line that is not a move, with the reason."""


class UnknownPosition(GcodeFault):
    """A relative move, and nobody knows from where."""


@dataclass(frozen=True, slots=True)
class Step:
    """`move` to a position in mm of the program, or `home`; feed None: the gantry's default."""

    verb: str
    place_mm: Mapping[str, float] = field(default_factory=dict)
    feed_mm_min: float | None = None


@dataclass(slots=True)
class _Modes:
    here: dict[str, float]
    motion: float = 0.0
    scale_mm: float = 1.0
    relative: bool = False
    feed: float | None = None


def steps(program: str, here_mm: Mapping[str, float]) -> list[Step]:
    """The steps of a program that begins at `here_mm`; raises GcodeFault."""
    modes = _Modes(dict(here_mm))
    found = [step for line in program.splitlines() for step in _line(line, modes)]
    if not found:
        raise GcodeFault("it contains no move, such as `G0 X10 Y20`")
    return found


def _line(line: str, modes: _Modes) -> Iterator[Step]:
    plain = COMMENT.sub("", line).strip()
    if not plain:
        return
    if plain.upper() == "$H":
        modes.here.clear()
        yield Step("home")
        return
    given: dict[str, float] = {}
    at = 0
    while at < len(plain):
        word = WORD.match(plain, at)
        if word is None:
            raise GcodeFault(f"{plain!r}: {plain[at:].strip()[:20]!r} is not a word of G-code")
        at = word.end()
        _word(word[1].upper(), float(word[2]), given, modes, plain)
    if given:
        yield _move(given, modes)


def _word(letter: str, value: float, given: dict[str, float], modes: _Modes, line: str) -> None:
    if letter in AXES:
        if letter.lower() in given:
            raise GcodeFault(f"{line!r}: {letter} occurs twice")
        given[letter.lower()] = value
    elif letter == "F":
        modes.feed = value
    elif letter == "G" and value in MOVES:
        modes.motion = value
    elif letter == "G" and value in (20.0, 21.0):
        modes.scale_mm = INCH_MM if value == 20.0 else 1.0
    elif letter == "G" and value in (90.0, 91.0):
        modes.relative = value == 91.0
    elif letter != "N" and not (letter == "G" and value in PLANES):
        raise GcodeFault(
            f"{line!r}: {letter}{value:g} is not a move; supported are G0, G1, $H and modes"
        )


def _move(given: dict[str, float], modes: _Modes) -> Step:
    place = {}
    for axis, value in given.items():
        mm = value * modes.scale_mm
        place[axis] = modes.here.get(axis, math.nan) + mm if modes.relative else mm
        if not math.isfinite(place[axis]):
            raise UnknownPosition(f"{axis} is relative to an unknown position")
    modes.here.update(place)
    fast = modes.motion == 0.0 or modes.feed is None
    return Step("move", place, None if fast or modes.feed is None else modes.feed * modes.scale_mm)
