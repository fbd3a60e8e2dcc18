"""One number over many runs, with limits: Shewhart's chart of single values.

The limits are mean ± 2.66 times the mean moving range, three standard deviations of what varies
from one run to the next (ISO 7870-2); a drift does not widen them as it would a standard deviation.
"""

from dataclasses import dataclass
from itertools import pairwise

from ..language.suggest import did_you_mean
from .entry import Entry

FACTOR = 2.66
"""3 / d2, with d2 = 1.128 for ranges of two."""
FEWEST = 3


@dataclass(frozen=True, slots=True)
class Chart:
    """`points`: run and number, oldest first. `low`, `mean`, `high` are None for fewer than three."""

    name: str
    unit: str
    points: list[tuple[Entry, float]]
    low: float | None = None
    mean: float | None = None
    high: float | None = None

    def is_out(self, number: float) -> bool:
        """True beyond a limit."""
        return (
            self.low is not None and self.high is not None and not self.low <= number <= self.high
        )


def chart(entries: list[Entry], name: str) -> Chart:
    """The chart of a number that runs came to (an output, or the mean of a column), or of a parameter."""
    points = [(entry, *told) for entry in entries if (told := entry.number(name)) is not None]
    units = [unit for _, _, unit in points]
    unit = units[-1] if units else ""
    alike = [(entry, number) for entry, number, of in points if of == unit]
    numbers = [number for _, number in alike]
    if len(numbers) < FEWEST:
        return Chart(name, unit, alike)
    mean = sum(numbers) / len(numbers)
    ranges = [abs(a - b) for a, b in pairwise(numbers)]
    width = FACTOR * sum(ranges) / len(ranges)
    return Chart(name, unit, alike, mean - width, mean, mean + width)


def names(entries: list[Entry]) -> list[str]:
    """Every number that these runs have."""
    return sorted({name for entry in entries for name in entry.numbers})


def none_has(entries: list[Entry], name: str) -> str:
    """That no run has this number, and which ones there are."""
    known = names(entries)
    there = ", ".join(known[:20]) or "no number in any of them"
    return f"none of {len(entries)} runs has {name}{did_you_mean(name, known)}; there is {there}"
