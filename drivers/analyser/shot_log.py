"""The shot log: every shot is on disk before its click, so that a kill cannot hide one.

An analyser's program and server know no goals and give no numbers. Which goal requested which shot,
what was in the cache before, and the outcome are recorded here: one SQLite file, fully synced.
"""

import json
import sqlite3
from collections.abc import Iterable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

Fate = Literal["begun", "fired", "denied"]
"""`begun`: not known yet. `denied`: it certainly did not happen."""

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
    """A goal whose shot is already in the log: it is not clicked a second time."""


@dataclass(frozen=True, slots=True)
class Shot:
    """One shot: the goal that requested it, and what is known about it.

    `before` are the names in the cache before the click, null if the cache cannot be seen;
    `entry` is what it left there; `exported` the SHA-256 of its stored spectrum; `asked` the
    names in the export folder before an export was requested.
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


class ShotLog:
    """Shots in the order in which they began; raises OSError if the disk cannot be written."""

    def __init__(self, path: Path) -> None:
        self.path = path
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            with ExitStack() as on_failure:
                self._disk = sqlite3.connect(path, isolation_level=None, timeout=BUSY_S)
                on_failure.callback(self._disk.close)
                self._disk.execute("PRAGMA journal_mode = WAL")
                self._disk.execute("PRAGMA synchronous = FULL")
                self._disk.executescript(TABLES)
                on_failure.pop_all()
        except sqlite3.Error as fault:
            raise OSError(f"the shot log {path} cannot be opened: {fault}") from fault

    def close(self) -> None:
        self._disk.close()

    def begin(self, goal: str, at: float, before: Iterable[str] | None) -> Shot:
        """Record a new shot, on disk when this returns: only then may the click be made."""
        try:
            number = self._write(
                "INSERT INTO shots (goal, fate, at, before) VALUES (?, 'begun', ?, ?)",
                goal, at, _text(before),
            )  # fmt: skip
        except sqlite3.IntegrityError:
            raise AlreadyBegun(f"the shot of {goal} was begun before; it is not repeated") from None
        return self._one("WHERE number = ?", number)  # type: ignore[return-value]

    def fired(self, shot: Shot, entry: str | None) -> None:
        """It happened; `entry` is what it left in the cache, if that can be seen."""
        self._write(
            "UPDATE shots SET fate = 'fired', entry = ? WHERE number = ?", entry, shot.number
        )

    def denied(self, shot: Shot) -> None:
        """It certainly did not happen."""
        self._write("UPDATE shots SET fate = 'denied' WHERE number = ?", shot.number)

    def asked(self, shot: Shot, names: Iterable[str]) -> None:
        """Its export is about to be requested; these were the names in the export folder before."""
        self._write("UPDATE shots SET asked = ? WHERE number = ?", _text(names), shot.number)

    def exported(self, shot: Shot, sha256: str) -> None:
        """Its spectrum is stored."""
        self._write("UPDATE shots SET exported = ? WHERE number = ?", sha256, shot.number)

    def newest(self) -> Shot | None:
        """The latest shot that may have happened."""
        return self._one("WHERE fate != 'denied' ORDER BY number DESC LIMIT 1")

    def shot(self, name: str) -> Shot | None:
        """The shot with that name, if it was begun here."""
        prefix, _, number = name.rpartition("-")
        if prefix != "shot" or not (number.isascii() and number.isdigit()):
            return None
        found = self._one("WHERE number = ?", int(number))
        return found if found is not None and found.name == name else None

    def shot_with(self, sha256: str) -> Shot | None:
        """The shot whose stored spectrum has this SHA-256."""
        return self._one("WHERE exported = ? LIMIT 1", sha256)

    def count(self) -> int:
        """How many shots were certainly fired."""
        return self._ask("SELECT count(*) FROM shots WHERE fate = 'fired'")[0]

    def fact(self, name: str) -> str | None:
        """A stored fact about this analyser."""
        row = self._disk.execute("SELECT value FROM facts WHERE name = ?", (name,)).fetchone()
        return None if row is None else row[0]

    def learn(self, name: str, value: str) -> None:
        """Store a fact about this analyser."""
        self._write("INSERT OR REPLACE INTO facts VALUES (?, ?)", name, value)

    def _write(self, sql: str, *values: Any) -> int:
        try:
            return self._disk.execute(sql, values).lastrowid or 0
        except sqlite3.OperationalError as fault:
            raise OSError(f"the shot log {self.path} cannot be written: {fault}") from fault

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
