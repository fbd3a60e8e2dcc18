"""What each device did when: in a fixed number of columns, however long it lasted."""

import math
from itertools import count, takewhile

KEPT = 960
"""Columns in memory; they grow wider as the run grows longer."""
WIDTHS_S = (
    1,
    2,
    5,
    10,
    15,
    30,
    60,
    120,
    300,
    600,
    900,
    1800,
    3600,
    7200,
    14400,
    21600,
    43200,
    86400,
)
"""Between two marks on an axis of time; beyond these, whole weeks."""


class Gantt:
    """Takes actions from first to last; `from_s` and `to_s` are the part of the time that is looked at."""

    def __init__(self, from_s: float = 0.0, to_s: float | None = None) -> None:
        self.from_s, self.to_s = from_s, to_s
        self._column_s = 0.01
        self._busy: dict[str, list[float]] = {}

    def add(self, label: str, began_s: float, ended_s: float) -> None:
        """An action, `gantry.move_to`, was under way from then to then."""
        began_s = max(began_s - self.from_s, 0.0)
        ended_s = min(ended_s, ended_s if self.to_s is None else self.to_s) - self.from_s
        if ended_s <= began_s:
            return
        while ended_s > KEPT * self._column_s:
            self._column_s *= 2
            self._busy = {name: _halved(row) for name, row in self._busy.items()}
        row = self._busy.setdefault(label, [0.0] * KEPT)
        _spread(row, self._column_s, began_s, ended_s, 1.0)

    def rows(self, columns: int, lasts_s: float) -> dict[str, list[float]]:
        """By action, the share of each column's time in which it was under way, from 0 to 1.

        The columns divide the time that is looked at, of a run that has lasted so long. Actions of one device
        stand together.
        """
        width_s = self.span_s(lasts_s) / columns
        devices = list(dict.fromkeys(label.partition(".")[0] for label in self._busy))
        made: dict[str, list[float]] = {}
        for label in sorted(self._busy, key=lambda one: devices.index(one.partition(".")[0])):
            row = made[label] = [0.0] * columns
            for n, busy_s in enumerate(self._busy[label]):
                if busy_s:
                    at_s = n * self._column_s
                    _spread(row, width_s, at_s, at_s + self._column_s, busy_s / self._column_s)
            made[label] = [min(1.0, round(busy_s / width_s, 3)) for busy_s in row]
        return made

    def span_s(self, lasts_s: float) -> float:
        """How much of a run that has lasted so long is looked at."""
        end_s = lasts_s if self.to_s is None else min(self.to_s, lasts_s)
        return max(end_s - self.from_s, 0.01)


def _spread(row: list[float], width_s: float, began_s: float, ended_s: float, part: float) -> None:
    """Add what lies between two moments to the columns that it lies in."""
    last = len(row) - 1
    first, end = min(int(began_s / width_s), last), min(int(ended_s / width_s), last)
    if first == end:
        row[first] += part * (ended_s - began_s)
        return
    row[first] += part * ((first + 1) * width_s - began_s)
    for n in range(first + 1, end):
        row[n] += part * width_s
    row[end] += part * (ended_s - end * width_s)


def _halved(row: list[float]) -> list[float]:
    pairs = zip(row[::2], row[1::2], strict=True)
    return [one + other for one, other in pairs] + [0.0] * (len(row) // 2)


def marks(from_s: float, span_s: float, most: int) -> list[tuple[float, str]]:
    """Round moments to write on the axis, and how; at most so many."""
    weeks = (n * 7 * 86400 for n in count(1))
    widths = (*WIDTHS_S, *takewhile(lambda s: s < 2 * span_s + 14 * 86400, weeks))
    width_s = next(s for s in widths if span_s / s < most)
    first = math.ceil(from_s / width_s)
    moments = takewhile(lambda s: s < from_s + span_s, (n * width_s for n in count(first)))
    return [(moment, _words(moment)) for moment in moments]


def _words(moment: int) -> str:
    """`0`, `30 s`, `1:30 min`, `2 h`, `2:30 h`, `26 h`."""
    if moment % 3600 == 0:
        return f"{moment // 3600} h" if moment else "0"
    if moment > 3600:
        return f"{moment // 3600}:{moment % 3600 // 60:02} h"
    if moment % 60 == 0:
        return f"{moment // 60} min"
    return f"{moment // 60}:{moment % 60:02} min" if moment > 60 else f"{moment} s"
