"""Keep the rows of spectra on disk until all are there, and give them back in any order."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from .work import Done


@dataclass(slots=True)
class _Kept:
    done: Done  # without its rows
    places: dict[str, tuple[int, int]]


class Spool:
    """A file of rows; what is put under a name again takes the place of what was there."""

    def __init__(self, path: Path) -> None:
        self.file = path.open("w+b")
        self.kept: dict[str, _Kept] = {}
        self.end = 0
        self.puts = 0  # how often something was put

    def __len__(self) -> int:
        return len(self.kept)

    def put(self, done: Done) -> None:
        """Keep one. Raises OSError when the disk is full."""
        self.file.seek(self.end)
        places = {}
        for table, raw in done.rows.items():
            self.file.write(raw)
            places[table] = (self.end, len(raw))
            self.end += len(raw)
        self.kept[done.name] = _Kept(replace(done, rows={}), places)
        self.puts += 1

    def rows(self, name: str) -> dict[str, bytes]:
        """The packed rows of one spectrum by table."""
        found = {}
        for table, (at, length) in self.kept[name].places.items():
            self.file.seek(at)
            found[table] = self.file.read(length)
        return found

    def told(self) -> Iterator[Done]:
        """What is known of each, without its rows, in the order in which they came."""
        return (kept.done for kept in self.kept.values())

    def close(self) -> None:
        """Let go of the file; what a full disk still refuses is lost with it."""
        with suppress(OSError):
            self.file.close()
