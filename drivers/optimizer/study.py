"""A study: what was defined, suggested and told, read back from its log."""

import json
import sqlite3
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .problem import Point, Problem

Values = dict[str, float | None]
TABLE = """CREATE TABLE IF NOT EXISTS lines (
    number INTEGER PRIMARY KEY AUTOINCREMENT, goal TEXT NOT NULL, study TEXT NOT NULL,
    what TEXT NOT NULL, said TEXT NOT NULL
)"""
BUSY_S = 2.0


class StudyLog:
    """Every define, ask and tell, in order, on disk before it is answered; raises OSError."""

    def __init__(self, path: Path) -> None:
        self.path = path
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            self._disk = sqlite3.connect(path, isolation_level=None, timeout=BUSY_S)
            self._disk.execute("PRAGMA journal_mode = WAL")
            self._disk.execute("PRAGMA synchronous = FULL")
            self._disk.execute(TABLE)
        except sqlite3.Error as fault:
            raise OSError(f"the log of studies {path} cannot be opened: {fault}") from fault

    def close(self) -> None:
        self._disk.close()

    def add(self, goal: str, study: str, what: str, said: Any) -> None:
        """Write it down: on disk when this returns."""
        row = (goal, study, what, json.dumps(said))
        try:
            self._disk.execute(
                "INSERT INTO lines (goal, study, what, said) VALUES (?, ?, ?, ?)", row
            )
        except sqlite3.Error as fault:
            raise OSError(f"the log of studies {self.path} cannot be written: {fault}") from fault

    def newest(self, what: str, run: str = "") -> tuple[str, str, Any] | None:
        """Goal, study and content of the newest line of a kind, of one run if it is named."""
        where = "WHERE what = ? AND substr(goal, 1, ?) = ? ORDER BY number DESC LIMIT 1"
        begins = f"{run}/" if run else ""
        rows = self._rows(where, what, len(begins), begins)
        return next(((goal, study, said) for goal, study, _, said in rows), None)

    def of_goal(self, goal: str) -> Any:
        """What was written for a goal; None if nothing was."""
        return next((said for *_, said in self._rows("WHERE goal = ?", goal)), None)

    def of_study(self, study: str) -> Iterator[tuple[str, Any]]:
        """Kind and content of every line of a study, in order."""
        for _, _, what, said in self._rows("WHERE study = ? ORDER BY number", study):
            yield what, said

    def _rows(self, where: str, *values: Any) -> Iterator[tuple[str, str, str, Any]]:
        sql = f"SELECT goal, study, what, said FROM lines {where}"
        for goal, study, what, said in self._disk.execute(sql, values):
            yield goal, study, what, json.loads(said)


@dataclass(slots=True)
class Study:
    """All that a suggestion depends on.

    `asked` counts suggestions, `at` and `values` are what was told, `waiting` was suggested and
    nothing has been told of it; `void` are places that came to nothing.
    """

    name: str
    problem: Problem
    asked: int = 0
    told: int = 0
    at: list[Point] = field(default_factory=list)
    values: list[dict[str, float]] = field(default_factory=list)
    waiting: list[Point] = field(default_factory=list)
    void: list[Point] = field(default_factory=list)

    def suggested(self, points: list[Point]) -> None:
        """These have been suggested."""
        self.asked += len(points)
        self.waiting += points

    def tell(self, at: Point, values: Values) -> None:
        """This was measured there."""
        self.told += 1
        known = {name: value for name, value in values.items() if value is not None}
        if len(known) == len(values):
            self.at.append(at)
            self.values.append(known)
        else:
            self.void.append(at)
        spot = next((n for n, point in enumerate(self.waiting) if is_same(point, at)), None)
        if spot is not None:
            del self.waiting[spot]


def is_same(one: Point, other: Point) -> bool:
    """Whether two points are the same but for rounding."""
    return all(
        abs(value - other[name]) <= 1e-9 * max(1.0, abs(value))
        if isinstance(value, int | float) and isinstance(other[name], int | float)
        else value == other[name]
        for name, value in one.items()
    )
