"""The book of shots: every shot is on disk before its click, so that a kill cannot hide one.

An analyser's program and server know no goals and give no numbers. Which goal asked for which
shot, what lay in the cache before, and what came of it, stands here: one SQLite file, fully synced.
"""

import json
import sqlite3
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

Fate = Literal["begun", "fired", "denied"]
"""`begun`: nobody knows yet. `denied`: it surely did not happen."""

TABLES = """
CREATE TABLE IF NOT EXISTS shots (
    number INTEGER PRIMARY KEY AUTOINCREMENT, goal TEXT NOT NULL UNIQUE, fate TEXT NOT NULL,
    at REAL NOT NULL, before TEXT, entry TEXT, exported TEXT, asked TEXT
);
CREATE TABLE IF NOT EXISTS facts (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
"""
ROW = "SELECT number, goal, fate, at, before, entry, exported, asked FROM shots "
BUSY_S = 2.0


class AlreadyBegun(Exception):
    """A goal whose shot stands in the book: it is not clicked a second time."""


@dataclass(frozen=True, slots=True)
class Shot:
    """One shot: the goal that asked for it, and what is known of it.

    `before` are the names in the cache before the click, null where the cache cannot be seen;
    `entry` is what it left there; `exported` the SHA-256 of its spectrum, which is kept; `asked`
    the names in the export folder before an export was asked for.
    """

    number: int
    goal: str
    fate: Fate
    at: float
    before: frozenset[str] | None
    entry: str | None
    exported: str | None
    asked: frozenset[str] | None

    @property
    def name(self) -> str:
        return f"shot-{self.number:06d}"


class ShotBook:
    """Shots in the order in which they were begun; raises OSError where the disk takes nothing."""

    def __init__(self, path: Path) -> None:
        self.path = path
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            self._disk = sqlite3.connect(path, isolation_level=None, timeout=BUSY_S)
            self._disk.execute("PRAGMA journal_mode = WAL")
            self._disk.execute("PRAGMA synchronous = FULL")
            self._disk.executescript(TABLES)
        except sqlite3.Error as fault:
            raise OSError(f"the book of shots {path} cannot be opened: {fault}") from fault

    def close(self) -> None:
        self._disk.close()

    def begin(self, goal: str, at: float, before: Iterable[str] | None) -> Shot:
        """A new shot, on disk when this returns: only then may the click be made."""
        try:
            number = self._write(
                "INSERT INTO shots (goal, fate, at, before) VALUES (?, 'begun', ?, ?)",
                goal, at, _text(before),
            )  # fmt: skip
        except sqlite3.IntegrityError:
            raise AlreadyBegun(
                f"the shot of {goal} was begun before; it is not made again"
            ) from None
        return self._one("WHERE number = ?", number)  # type: ignore[return-value]

    def fired(self, shot: Shot, entry: str | None) -> None:
        """It happened; `entry` is what it left in the cache, where that can be seen."""
        self._write(
            "UPDATE shots SET fate = 'fired', entry = ? WHERE number = ?", entry, shot.number
        )

    def denied(self, shot: Shot) -> None:
        """It surely did not happen."""
        self._write("UPDATE shots SET fate = 'denied' WHERE number = ?", shot.number)

    def asked(self, shot: Shot, names: Iterable[str]) -> None:
        """Its export is about to be asked for; these were the names in the export folder before."""
        self._write("UPDATE shots SET asked = ? WHERE number = ?", _text(names), shot.number)

    def exported(self, shot: Shot, sha256: str) -> None:
        """Its spectrum is kept."""
        self._write("UPDATE shots SET exported = ? WHERE number = ?", sha256, shot.number)

    def newest(self) -> Shot | None:
        """The newest shot that may have happened."""
        return self._one("WHERE fate != 'denied' ORDER BY number DESC LIMIT 1")

    def shot(self, name: str) -> Shot | None:
        """The shot of that name, if it was begun here."""
        prefix, _, number = name.rpartition("-")
        if prefix != "shot" or not (number.isascii() and number.isdigit()):
            return None
        found = self._one("WHERE number = ?", int(number))
        return found if found is not None and found.name == name else None

    def shot_with(self, sha256: str) -> Shot | None:
        """The shot whose kept spectrum has this SHA-256."""
        return self._one("WHERE exported = ? LIMIT 1", sha256)

    def count(self) -> int:
        """How many shots were surely fired."""
        return self._ask("SELECT count(*) FROM shots WHERE fate = 'fired'")[0]

    def fact(self, name: str) -> str | None:
        """A thing that was learned of this analyser."""
        row = self._disk.execute("SELECT value FROM facts WHERE name = ?", (name,)).fetchone()
        return None if row is None else row[0]

    def learn(self, name: str, value: str) -> None:
        """Keep a thing that was learned."""
        self._write("INSERT OR REPLACE INTO facts VALUES (?, ?)", name, value)

    def _write(self, sql: str, *values: Any) -> int:
        try:
            return self._disk.execute(sql, values).lastrowid or 0
        except sqlite3.OperationalError as fault:
            raise OSError(f"the book of shots {self.path} cannot be written: {fault}") from fault

    def _ask(self, sql: str, *values: Any) -> Any:
        return self._disk.execute(sql, values).fetchone()

    def _one(self, where: str, *values: Any) -> Shot | None:
        row = self._ask(ROW + where, *values)
        if row is None:
            return None
        number, goal, fate, at, before, entry, exported, asked = row
        return Shot(number, goal, fate, at, _names(before), entry, exported, _names(asked))


def _text(names: Iterable[str] | None) -> str | None:
    return None if names is None else json.dumps(sorted(names))


def _names(text: str | None) -> frozenset[str] | None:
    return None if text is None else frozenset(json.loads(text))
