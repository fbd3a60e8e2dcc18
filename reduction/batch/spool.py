"""Keep the rows of spectra on disk until all are complete, and return them in any order."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from .work import Done


@dataclass(slots=True)
class _Kept:
    done: Done  # without its rows
    at: int
    length: int


class Spool:
    """A file of rows; rows put under the same name again replace the earlier ones."""

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
        self.file.write(done.rows)
        self.kept[done.name] = _Kept(replace(done, rows=b""), self.end, len(done.rows))
        self.end += len(done.rows)
        self.puts += 1

    def rows(self, name: str) -> bytes:
        """The packed rows of one spectrum."""
        kept = self.kept[name]
        self.file.seek(kept.at)
        return self.file.read(kept.length)

    def done(self) -> Iterator[Done]:
        """The results without rows, in order of arrival."""
        return (kept.done for kept in self.kept.values())

    def close(self) -> None:
        """Close the file; data that a full disk still refuses is lost with it."""
        with suppress(OSError):
            self.file.close()
