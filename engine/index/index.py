"""The index of runs: a small database beside them, brought up to date whenever it is asked."""

import json
import os
import sqlite3
from collections.abc import Iterator
from contextlib import closing, suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

from ...system.files import remove
from ..run.folder import JOURNAL
from .entry import COLUMNS, Entry, entry_of
from .wanted import Wanted, compared, wanted

FILE = ".index.sqlite"
VERSION = 1
"""Of what is in it; an index of another version is made anew."""
WAIT_S = 5.0
NAMES = ", ".join(f'"{name}"' for name in COLUMNS)
LIVE = ("running", "")
"""Fates that are looked at anew each time: such a run writes on."""


def find_runs(runs: Path, text: str = "") -> list[Entry]:
    """The runs of a folder for which a search holds, oldest first; raises NotUnderstood."""
    sought = wanted(text)
    place = runs / FILE
    try:
        return _found(runs, sought, place if runs.is_dir() else None)
    except sqlite3.DatabaseError as fault:
        if type(fault) is sqlite3.DatabaseError:  # damaged, and not merely locked or read-only
            with suppress(OSError):
                remove(place)
        return _found(runs, sought, None)


def _found(runs: Path, sought: Wanted, place: Path | None) -> list[Entry]:
    with closing(_connected(place)) as base:
        _refresh(base, runs)
        rows = base.execute(
            f"SELECT {NAMES} FROM runs WHERE {sought.where} ORDER BY began, run", sought.values
        )
        return list(map(Entry._make, rows))


def _connected(place: Path | None) -> sqlite3.Connection:
    base = sqlite3.connect(place or ":memory:", timeout=WAIT_S, isolation_level=None)
    try:
        base.execute("PRAGMA synchronous=OFF")  # it is made again
        base.create_function("compared", 5, _compared, deterministic=True)
        if base.execute("PRAGMA user_version").fetchone()[0] != VERSION:
            base.execute("BEGIN IMMEDIATE")
            base.execute("DROP TABLE IF EXISTS runs")
            base.execute(f"CREATE TABLE runs ({NAMES}, words, mark, PRIMARY KEY (run))")
            base.execute("CREATE INDEX by_time ON runs (began, run)")
            base.execute(f"PRAGMA user_version={VERSION}")
            base.execute("COMMIT")
    except sqlite3.Error:
        base.close()
        raise
    return base


def _refresh(base: sqlite3.Connection, runs: Path) -> None:
    """Look at the folders that have changed since, and forget those that have gone."""
    known = dict(base.execute("SELECT run, mark FROM runs"))
    there = dict(_marks(runs))
    changed = [name for name, mark in there.items() if known.get(name) != mark]
    gone = known.keys() - there.keys()
    if not changed and not gone:
        return
    made = [(entry_of(runs / name), there[name]) for name in changed]
    holes = ", ".join("?" * (len(COLUMNS) + 2))
    rows = [(*entry, entry.words(), "" if entry.fate in LIVE else mark) for entry, mark in made]
    base.execute("BEGIN IMMEDIATE")
    base.executemany(f"INSERT OR REPLACE INTO runs VALUES ({holes})", rows)
    base.executemany("DELETE FROM runs WHERE run = ?", [(name,) for name in gone])
    base.execute("COMMIT")


def _marks(runs: Path) -> Iterator[tuple[str, str]]:
    """Each run with what changes when anything is written in its folder."""
    try:
        with os.scandir(runs) as found:
            for entry in found:
                try:
                    journal = os.stat(f"{entry.path}{os.sep}{JOURNAL}")  # noqa: PTH116
                    folder = entry.stat()
                except OSError:
                    continue
                yield entry.name, f"{journal.st_size} {journal.st_mtime_ns} {folder.st_mtime_ns}"
    except OSError:
        return


def _compared(params: str, numbers: str, name: str, sign: str, text: str) -> bool:
    return compared(_read(params), _read(numbers), name, sign, text)


@lru_cache(maxsize=1024)
def _read(text: str) -> dict[str, Any]:
    return json.loads(text)
