"""Follow a journal as it grows: only new records are read; an incomplete last line waits for its end."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ...engine.journal.journal import chain

CHUNK = 256 * 1024
MARK = b',"hash":"'


class Damaged(Exception):
    """The hash chain is broken; the records before are valid."""


class Follower:
    """Reads records as plain data, each with the offset of its line, and checks their chain."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.offset = 0
        self.number = 0
        self._hash = ""

    @property
    def behind(self) -> int:
        """Bytes that have not been read yet."""
        try:
            return self.path.stat().st_size - self.offset
        except OSError:
            return 0

    def records(self, most_bytes: int | None = None) -> Iterator[tuple[int, dict[str, Any]]]:
        """Every new complete record; raises Damaged, OSError.

        With `most_bytes` it ends after about that many, so that other tasks get their turn.
        """
        end = None if most_bytes is None else self.offset + most_bytes
        with self.path.open("rb") as file:
            file.seek(self.offset)
            rest = b""
            while chunk := file.read(CHUNK):
                *lines, rest = (rest + chunk).split(b"\n")
                for line in lines:
                    start = self.offset
                    self.offset += len(line) + 1
                    yield start, self._record(line)
                if end is not None and self.offset >= end:
                    return

    def _record(self, line: bytes) -> dict[str, Any]:
        body, mark, tail = line.rpartition(MARK)
        self.number += 1
        text = body.decode("utf-8", "surrogateescape")
        self._hash, before = tail[:-2].decode("ascii", "replace"), self._hash
        if not mark or chain(before, text) != self._hash:
            self.offset -= len(line) + 1
            raise Damaged(f"the journal is damaged at record {self.number}")
        return json.loads(line)


def read_at(path: Path, offsets: list[int]) -> list[dict[str, Any]]:
    """The records at these offsets."""
    found = []
    with path.open("rb") as file:
        for offset in offsets:
            file.seek(offset)
            found.append(json.loads(file.readline()))
    return found


def read_between(path: Path, start: int, end: int) -> Iterator[dict[str, Any]]:
    """The records from one offset to another, inclusive."""
    with path.open("rb") as file:
        file.seek(start)
        at = start
        for line in file:
            if at > end or not line.endswith(b"\n"):
                return
            at += len(line)
            yield json.loads(line)
