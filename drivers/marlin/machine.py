"""What Marlin says of its machine: speeds, ranges, positions."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ..motion.bench import Point

AXES = "XYZ"
PLACE = re.compile(r"\s*".join(f"{axis}:\\s*(?P<{axis}>-?\\d+\\.\\d+)" for axis in AXES))
STEPS = re.compile(r"Count X:\s*(-?\d+)\s*Y:\s*(-?\d+)\s*Z:\s*(-?\d+)")
WORD = re.compile(r"([A-Z])\s*:?\s*(-?\d+(?:\.\d+)?)")


@dataclass(frozen=True, slots=True)
class Machine:
    """Speeds in mm/s, accelerations in mm/s2, ranges in mm."""

    speed: Point = (50.0, 50.0, 5.0)
    acceleration: Point = (500.0, 500.0, 50.0)
    steps_per_mm: Point = (80.0, 80.0, 400.0)
    ranges: tuple[tuple[float, float], ...] = ((0.0, 200.0),) * 3
    quick_stop: bool = False
    """Whether it takes a stop while it is busy (its emergency parser)."""

    @property
    def tolerance(self) -> float:
        """M114 shows two decimals."""
        return max(0.0055, 0.5 / min(self.steps_per_mm) + 0.005)


def read_machine(told: Iterable[str], capabilities: Iterable[str]) -> Machine:
    """From the lines of M503 and M211, and of M115; raises ValueError if a speed or range is missing."""
    lines = [line.removeprefix("echo:").strip() for line in told]
    found: dict[str, dict[str, float]] = {}
    for text in lines:
        if text.startswith(("M92 ", "M203 ", "M201 ", "M204 ")):
            code, _, rest = text.partition(" ")
            found[code] = _words(rest)
    for code, what in (("M92", "steps"), ("M203", "speeds"), ("M201", "accelerations")):
        if not set(AXES) <= set(found.get(code, {})):
            raise ValueError(f"its settings (M503) do not say its {what} ({code})")
    most = found.get("M204", {}).get("T", float("inf"))
    return Machine(
        speed=tuple(found["M203"][a] for a in AXES),
        acceleration=tuple(min(found["M201"][a], most) for a in AXES),
        steps_per_mm=tuple(found["M92"][a] for a in AXES),
        ranges=read_ranges(lines),
        quick_stop="Cap:EMERGENCY_PARSER:1" in capabilities,
    )


def read_ranges(told: Iterable[str]) -> tuple[tuple[float, float], ...]:
    """From the lines of M211: of the zero that it has now, so homing may change them. Raises ValueError."""
    for line in told:
        if "Min:" in line and "Max:" in line:
            low, high = (_words(part) for part in line.partition("Min:")[2].split("Max:"))
            if set(AXES) <= set(low) and set(AXES) <= set(high):
                return tuple((low[a], high[a]) for a in AXES)
    raise ValueError("it does not say its ranges (M211): build it with software endstops")


def read_place(told: Sequence[str]) -> Point | None:
    """The position in an answer to M114, in mm; None if there is none.

    The steps that follow it bear the same letters, and noise may have eaten the word between them.
    """
    places = (PLACE.match(line) for line in told)
    return next((tuple(float(found[axis]) for axis in AXES) for found in places if found), None)


def read_shift(told: Sequence[str], machine: Machine) -> Point | None:
    """How far the position in an answer to M114 is from the steps that it tells beside; in mm.

    At rest only a shift of its zero changes this, where its motors move one axis each.
    """
    place = read_place(told)
    steps = next((found for line in told if (found := STEPS.search(line))), None)
    if place is None or steps is None:
        return None
    counted = zip(place, map(int, steps.groups()), machine.steps_per_mm, strict=True)
    return tuple(at - count / per_mm for at, count, per_mm in counted)


def read_pins(told: Iterable[str]) -> str:
    """The engaged inputs in an answer to M119, as the contract's letters."""
    letters = {"x": "X", "y": "Y", "z": "Z", "z_probe": "P"}
    pins = ""
    for line in told:
        name, _, state = line.partition(":")
        letter = letters.get(name.removesuffix("_min").removesuffix("_max").strip())
        if letter and state.strip() == "TRIGGERED" and letter not in pins:
            pins += letter
    return pins


def _words(text: str) -> dict[str, float]:
    return {letter: float(number) for letter, number in WORD.findall(text)}
