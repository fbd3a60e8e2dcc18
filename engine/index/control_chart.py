"""One number over many runs, with limits: a person's own, or Shewhart's for single values.

Shewhart's are mean ± 2.66 times the mean moving range, three standard deviations of what varies
from one run to the next (ISO 7870-2); a drift does not widen them as it would a standard deviation.
"""

from dataclasses import dataclass
from itertools import pairwise

from ...schemas.quantity import UnitError, magnitude_in, quantity
from ..language.suggest import did_you_mean
from ..run.rows import unit_in
from .entry import Entry
from .wanted import CLOSE, NotUnderstood, number_in

FACTOR = 2.66
"""3 / d2, with d2 = 1.128 for ranges of two."""
FEWEST = 3


@dataclass(frozen=True, slots=True)
class Chart:
    """`points`: run and number, oldest first. `mean` is None for fewer than three.

    `low` and `high` are None where there is no limit: computed ones for fewer than three runs, of
    a person's own the other side.
    """

    name: str
    unit: str
    points: list[tuple[Entry, float]]
    low: float | None = None
    mean: float | None = None
    high: float | None = None

    def is_out(self, number: float) -> bool:
        """True beyond a limit, by more than the noise of a last digit."""
        return any(
            limit is not None and sign * (number - limit) > CLOSE * max(abs(number), abs(limit))
            for limit, sign in ((self.low, -1), (self.high, 1))
        )


def chart(entries: list[Entry], name: str, low: str = "", high: str = "") -> Chart:
    """The chart of a number that runs came to (an output, or the mean of a column), or of a parameter.

    `low`, `high`: limits instead of the computed ones, as `0.5 mm` or `3`, in the number's unit.
    Raises NotUnderstood for one that is none.
    """
    told = [(entry, *found) for entry in entries if (found := entry.number(name)) is not None]
    last = told[-1][2] if told else ""
    points = [
        (entry, same) for entry, number, own in told if (same := _in(number, own, last)) is not None
    ]
    unit = last or unit_in(name.partition(".")[2])
    numbers = [number for _, number in points]
    mean = sum(numbers) / len(numbers) if len(numbers) >= FEWEST else None
    if low or high:
        lowest, highest = _limit("low", low, name, unit), _limit("high", high, name, unit)
        if lowest is not None and highest is not None and lowest > highest:
            raise NotUnderstood(f"low {low} is above high {high}")
        return Chart(name, unit, points, lowest, mean, highest)
    if mean is None:
        return Chart(name, unit, points)
    ranges = [abs(a - b) for a, b in pairwise(numbers)]
    width = FACTOR * sum(ranges) / len(ranges)
    return Chart(name, unit, points, mean - width, mean, mean + width)


def _in(number: float, own: str, unit: str) -> float | None:
    """A run's number in the unit of the last run; None if it is of another kind."""
    if own == unit:
        return number
    try:
        return float(magnitude_in(quantity(number, own), unit)) if own and unit else None
    except UnitError:
        return None


def _limit(which: str, text: str, name: str, unit: str) -> float | None:
    if not text:
        return None
    number = number_in(text, unit)
    if number is None:
        such = f"is in {unit}: write 3, or `3 {unit}`" if unit else "has no unit: write a number"
        raise NotUnderstood(f"{which} {text}: {name} {such}")
    return number


def names(entries: list[Entry]) -> list[str]:
    """Every number that these runs have."""
    return sorted({name for entry in entries for name in entry.numbers})


def none_has(entries: list[Entry], name: str) -> str:
    """That no run has this number, and which ones there are."""
    known = names(entries)
    there = ", ".join(known[:20]) or "no number in any of them"
    return f"none of {len(entries)} runs has {name}{did_you_mean(name, known)}; there is {there}"
