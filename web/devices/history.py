"""What a device's status was over hours and days: by the minute, in the bench's own small database.

The oldest is dropped where it would grow beyond its limit. It is for people to look at, never the truth.
"""

import logging
import math
import sqlite3
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from ...schemas.quantity import is_number
from ...system.files import put
from ..models.devices import DeviceHistory, DeviceState, HistoryValue, Series, Trouble

LOG = logging.getLogger("labrun")
MINUTE_S = 60
LARGEST_BYTES = 64_000_000
MOST_POINTS = 400
MOST_TROUBLES = 100
TABLES = """
CREATE TABLE IF NOT EXISTS numbers (device, name, at INTEGER, low REAL, high REAL, last REAL,
    PRIMARY KEY (device, name, at)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS words (device, word, at INTEGER, reports INTEGER,
    PRIMARY KEY (device, word, at)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS troubles (device, at REAL, text);
CREATE INDEX IF NOT EXISTS troubles_at ON troubles (device, at);
"""

# A minute may be written twice: when it is looked at, and when it is over.
ADD_NUMBER = """
INSERT INTO numbers VALUES (?, ?, ?, ?, ?, ?) ON CONFLICT DO UPDATE SET
    low = MIN(low, excluded.low), high = MAX(high, excluded.high), last = excluded.last"""
ADD_WORD = """
INSERT INTO words VALUES (?, ?, ?, ?) ON CONFLICT DO UPDATE SET reports = reports + excluded.reports"""


@dataclass(slots=True)
class _Minute:
    """What a device has reported in the present minute: name -> lowest, highest, last; word -> reports."""

    at: int
    numbers: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    words: dict[str, int] = field(default_factory=dict)


class Histories:
    """Those of all devices; a minute is written when the next one begins."""

    def __init__(
        self, path: Path, largest_bytes: int = LARGEST_BYTES, clock: Callable[[], float] = time.time
    ) -> None:
        try:
            self._base = _opened(path)
        except sqlite3.DatabaseError as fault:
            LOG.error("%s is damaged and begins anew: %s", path, fault)
            put(path, path.with_suffix(".damaged"))
            self._base = _opened(path)
        self._largest_bytes = largest_bytes
        self._clock = clock
        self._minutes: dict[str, _Minute] = {}
        self._told: dict[str, str] = {}
        self._since: dict[str, str | None] = {}

    def close(self) -> None:
        """Write the present minute, and close the file."""
        for device in list(self._minutes):
            self._write(device)
        self._base.close()

    def note(self, state: DeviceState) -> None:
        """A device has reported, or was lost; a disk that takes nothing is logged and loses a minute."""
        device, at = state.name, int(self._clock() // MINUTE_S * MINUTE_S)
        try:
            if device in self._minutes and self._minutes[device].at != at:
                self._write(device)
            self._note_trouble(state)
        except sqlite3.Error as fault:
            LOG.error("the history of %s was not written: %s", device, fault)
        if state.status_at == self._since.get(device):
            return  # nothing new is said: it is lost, or only its user has changed
        self._since[device] = state.status_at
        minute = self._minutes.setdefault(device, _Minute(at))
        minute.words[state.word] = minute.words.get(state.word, 0) + 1
        for name, value in state.status.items():
            if is_number(value) and math.isfinite(value):
                low, high, _ = minute.numbers.get(name, (value, value, value))
                minute.numbers[name] = min(low, value), max(high, value), value

    def _note_trouble(self, state: DeviceState) -> None:
        """A row whenever it is lost, has a fault, or is well again."""
        fault = str(state.status.get("fault") or "")
        now = f"{state.reach}: {state.reason}" if state.reach in ("lost", "failed") else fault
        before = self._told.get(state.name, "")
        began = state.reach == "starting" or (state.reach == "lost" and state.status_at is None)
        if began or now == before:
            return
        self._told[state.name] = now
        row = (state.name, self._clock(), now or "well again")
        self._base.execute("INSERT INTO troubles VALUES (?, ?, ?)", row)

    def _write(self, device: str) -> None:
        minute = self._minutes.pop(device)
        numbers = [(device, n, minute.at, *value) for n, value in minute.numbers.items()]
        words = [(device, word, minute.at, count) for word, count in minute.words.items()]
        with self._base:
            self._base.execute("BEGIN")
            self._base.executemany(ADD_NUMBER, numbers)
            self._base.executemany(ADD_WORD, words)
        if self.bytes > self._largest_bytes:
            self._drop_oldest()

    @property
    def bytes(self) -> int:
        """What is kept; the file may be larger by pages that are used again."""
        pages, free, size = (
            self._base.execute(f"PRAGMA {what}").fetchone()[0]
            for what in ("page_count", "freelist_count", "page_size")
        )
        return (pages - free) * size

    def _drop_oldest(self) -> None:
        """The oldest tenth of the time that is kept."""
        first, last = self._base.execute("SELECT MIN(at), MAX(at) FROM words").fetchone()
        until = first + max((last - first) / 10, MINUTE_S)
        with self._base:
            self._base.execute("BEGIN")
            for table in ("numbers", "words", "troubles"):
                self._base.execute(f"DELETE FROM {table} WHERE at < ?", (until,))

    def read(self, device: str, since_s: float, name: str | None = None) -> DeviceHistory:
        """All of a device since a time; with the course of one of its numbers, thinned."""
        if device in self._minutes:
            self._write(device)
        of = (device, since_s)
        numbers = self._base.execute(
            "SELECT DISTINCT name, FIRST_VALUE(last) OVER one, LAST_VALUE(last) OVER one,"
            " MIN(low) OVER one, MAX(high) OVER one FROM numbers WHERE device = ? AND at >= ?"
            " WINDOW one AS (PARTITION BY name ORDER BY at"
            " ROWS BETWEEN UNBOUNDED PRECEDING AND UNBOUNDED FOLLOWING)",
            of,
        ).fetchall()
        words = self._base.execute(
            "SELECT word, SUM(reports) FROM words WHERE device = ? AND at >= ? GROUP BY word"
            " ORDER BY 2 DESC",
            of,
        ).fetchall()
        troubles = self._base.execute(
            "SELECT at, text FROM troubles WHERE device = ? AND at >= ? ORDER BY at DESC LIMIT ?",
            (*of, MOST_TROUBLES),
        ).fetchall()
        reports = sum(count for _, count in words) or 1
        return DeviceHistory(
            values=[
                HistoryValue(name=n, first=first, last=last, low=low, high=high)
                for n, first, last, low, high in sorted(numbers)
            ],
            words={word: count / reports for word, count in words},
            troubles=[Trouble(at_s=at, text=text) for at, text in troubles],
            series=self._series(device, since_s, name) if name is not None else None,
            bytes=self.bytes, largest_bytes=self._largest_bytes,
        )  # fmt: skip

    def _series(self, device: str, since_s: float, name: str) -> Series:
        """Lowest and highest of each part of the time."""
        part = max(
            MINUTE_S, math.ceil((self._clock() - since_s) / MOST_POINTS / MINUTE_S) * MINUTE_S
        )
        rows = self._base.execute(
            "SELECT MIN(at), MIN(low), MAX(high) FROM numbers"
            " WHERE device = ? AND at >= ? AND name = ? GROUP BY at / ? ORDER BY 1",
            (device, since_s, name, part),
        ).fetchall()
        at_s, low, high = zip(*rows, strict=True) if rows else ((), (), ())
        return Series(name=name, part_s=part, at_s=list(at_s), low=list(low), high=list(high))


def _opened(path: Path) -> sqlite3.Connection:
    base = sqlite3.connect(path, isolation_level=None, check_same_thread=False)
    try:
        base.execute("PRAGMA journal_mode=WAL")
        base.execute("PRAGMA synchronous=NORMAL")
        base.executescript(TABLES)
    except sqlite3.DatabaseError:
        base.close()
        raise
    return base
