"""The shot log: every shot is on disk before its click, so that a kill cannot hide one.

An analyser's program and server know no goals and give no numbers. Which goal requested which shot,
what was in the cache before, and the outcome are recorded here: one SQLite file, fully synced.
"""

import json
import sqlite3
from collections.abc import Iterable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

Fate = Literal["begun", "fired", "denied"]
"""`begun`: not known yet. `denied`: it certainly did not happen."""

TABLES = """
CREATE TABLE IF NOT EXISTS shots (
    number INTEGER PRIMARY KEY AUTOINCREMENT, goal TEXT NOT NULL UNIQUE, fate TEXT NOT NULL,
    at REAL NOT NULL, before TEXT, entry TEXT, exported TEXT, asked TEXT, typed TEXT, listed TEXT
);
CREATE TABLE IF NOT EXISTS seen (key TEXT PRIMARY KEY, number INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS facts (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
"""
ROW = "SELECT number, goal, fate, at, before, entry, exported, asked, typed FROM shots "
BUSY_S = 2.0


class AlreadyBegun(Exception):
    """A goal whose shot is already in the log: it is not clicked a second time."""


@dataclass(frozen=True, slots=True)
class Shot:
    """One shot: the goal that requested it, and what is known about it.

    `before` are the names in the cache before the click, null if the cache cannot be seen;
    `entry` is what it left there; `exported` the SHA-256 of its stored spectrum; `asked` the
    names in the export folder before an export was requested, `typed` what its exports are called.
    """

    number: int
    goal: str
    fate: Fate
    at: float
    before: frozenset[str] | None
    entry: str | None
    exported: str | None
    asked: frozenset[str] | None
    typed: frozenset[str]

    @property
    def name(self) -> str:
        return name_of(self.number)


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
                known = {row[1] for row in self._disk.execute("PRAGMA table_info(shots)")}
                for name in {"typed", "listed"} - known:  # a log of an earlier version
                    self._disk.execute(f"ALTER TABLE shots ADD COLUMN {name} TEXT")
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

    def asked(self, shot: Shot, names: Iterable[str], typed: str) -> Shot:
        """Its export is about to be requested; these were the names in the export folder before."""
        known = shot.typed | {typed}
        self._write(
            "UPDATE shots SET asked = ?, typed = ? WHERE number = ?",
            _text(names), _text(known), shot.number,
        )  # fmt: skip
        return replace(shot, asked=frozenset(names), typed=known)

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

    def earlier(self, shot: Shot) -> list[tuple[str, str | None, bool]]:
        """Every shot before this one that may have happened: its name, its entry, if it is stored."""
        rows = self._disk.execute(
            "SELECT number, entry, exported FROM shots WHERE fate != 'denied' AND number < ?",
            (shot.number,),
        )
        return [(name_of(number), entry, exported is not None) for number, entry, exported in rows]

    def last_brought(self, shot: Shot) -> str:
        """The latest earlier shot whose export brought something; empty if there is none."""
        row = self._ask("SELECT max(number) FROM seen WHERE number < ?", shot.number)
        return name_of(row[0]) if row[0] else ""

    def saw(self, shot: Shot, keys: Iterable[str], listed: Iterable[str] | None) -> None:
        """An export for this shot brought spectra with these keys, from this list of entries."""
        for key in keys:
            self._write("INSERT OR IGNORE INTO seen VALUES (?, ?)", key, shot.number)
        self._write("UPDATE shots SET listed = ? WHERE number = ?", _text(listed), shot.number)

    def forget_export(self, shot: Shot) -> None:
        """What its exports brought was nobody's: the next one is made anew."""
        self._write("UPDATE shots SET asked = NULL, typed = NULL WHERE number = ?", shot.number)

    def seen_at(self, shot: Shot, keys: Iterable[str]) -> str | None:
        """The earlier shot at whose export a spectrum with one of these keys was first seen."""
        for key in keys:
            row = self._ask("SELECT number FROM seen WHERE key = ?", key)
            row = row or self._ask("SELECT number FROM shots WHERE exported = ?", key)
            if row is not None and row[0] < shot.number:
                return name_of(row[0])
        return None

    def listed_before(self, shot: Shot) -> frozenset[str]:
        """What the cache held at the last export for an earlier shot that brought something."""
        row = self._ask(
            "SELECT listed FROM shots WHERE number < ? AND listed IS NOT NULL "
            "ORDER BY number DESC LIMIT 1", shot.number,
        )  # fmt: skip
        return (_names(row[0]) if row else None) or frozenset()

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
        return None if row is None else _shot(row)


def _shot(row: Any) -> Shot:
    number, goal, fate, at, before, entry, exported, asked, typed = row
    return Shot(
        number, goal, fate, at, _names(before), entry, exported, _names(asked),
        _names(typed) or frozenset(),
    )  # fmt: skip


def name_of(number: int) -> str:
    """How a shot is called."""
    return f"shot-{number:06d}"


def _text(names: Iterable[str] | None) -> str | None:
    return None if names is None else json.dumps(sorted(names))


def _names(text: str | None) -> frozenset[str] | None:
    return None if text is None else frozenset(json.loads(text))
