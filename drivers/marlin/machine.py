"""What Marlin says of its machine: speeds, ranges, positions."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ..motion.bench import Point

AXES = "XYZ"
PLACE = re.compile(r"\s*".join(f"{axis}:\\s*(?P<{axis}>-?\\d+\\.\\d+)" for axis in AXES))
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
    found: dict[str, dict[str, float]] = {}
    ranges: tuple[dict[str, float], dict[str, float]] | None = None
    for line in told:
        text = line.removeprefix("echo:").strip()
        if text.startswith(("M92 ", "M203 ", "M201 ", "M204 ")):
            code, _, rest = text.partition(" ")
            found[code] = _words(rest)
        elif "Min:" in text and "Max:" in text:
            low, _, high = text.partition("Max:")
            ranges = _words(low.partition("Min:")[2]), _words(high)
    for code, what in (("M92", "steps"), ("M203", "speeds"), ("M201", "accelerations")):
        if not set(AXES) <= set(found.get(code, {})):
            raise ValueError(f"its settings (M503) do not say its {what} ({code})")
    if ranges is None or not all(set(AXES) <= set(end) for end in ranges):
        raise ValueError("it does not say its ranges (M211): build it with software endstops")
    most = found.get("M204", {}).get("T", float("inf"))
    low, high = ranges
    return Machine(
        speed=tuple(found["M203"][a] for a in AXES),
        acceleration=tuple(min(found["M201"][a], most) for a in AXES),
        steps_per_mm=tuple(found["M92"][a] for a in AXES),
        ranges=tuple((low[a], high[a]) for a in AXES),
        quick_stop="Cap:EMERGENCY_PARSER:1" in capabilities,
    )


def read_place(told: Sequence[str]) -> Point | None:
    """The position in an answer to M114, in mm; None if there is none.

    The steps that follow it bear the same letters, and noise may have eaten the word between them.
    """
    places = (PLACE.match(line) for line in told)
    return next((tuple(float(found[axis]) for axis in AXES) for found in places if found), None)


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
