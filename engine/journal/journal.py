"""The journal: append-only records on disk, each chained to the last by a hash."""

import errno
import os
from collections import deque
from collections.abc import Iterator
from datetime import UTC, datetime
from hashlib import blake2b
from itertools import islice
from pathlib import Path
from typing import ClassVar, TypeVar

from pydantic import ValidationError

from ...drivers.server.newest_mark import NewestMark
from ...schemas.journal import FORMAT, RECORD, JournalRecord, Record
from ...schemas.model import first_fault
from ...system.files import BINARY, remove, sync_file

R = TypeVar("R", bound=Record)
RESERVE_BYTES = 256 * 1024
"""Space set aside at the start, so that a run on a full disk can still write how it ended."""
CHUNK = 256 * 1024
"""So much of a journal is read at a time."""


class JournalFault(Exception):
    """The journal cannot be read or written; the text says where and what to do."""


class NotWritten(JournalFault):
    """The next record of a run that was under way is not on disk."""


class DiskFull(JournalFault):
    """No space for the next record; the reserve was released, so the run can still be ended."""


KIND = b'"kind":'
NEWER = ("extra_forbidden", "union_tag_invalid")
"""The faults of a record that has a field, or is of a kind, that this labrun does not know."""
NONE = "none"
"""No record has this kind: only the chain is gone through."""


def chain(previous: str, body: str) -> str:
    """The hash of a record: over the hash of the last one and the record without its own."""
    return _chain(previous, body.encode(errors="surrogateescape"))


def _chain(previous: str, body: bytes) -> str:
    return blake2b(previous.encode() + body, digest_size=16).hexdigest()


class Journal:
    """Records are appended to a buffer; `flush` makes them durable, all with one fsync.

    What is durable is also noted where a backup of the run's folder does not put it back: `put_back` is
    true of a journal that lacks what was noted, `unsure` where nothing was.
    """

    on_real_disk: ClassVar[bool] = True

    def __init__(
        self, path: Path, *, count: int = 0, last_hash: str = "", sync: bool = True
    ) -> None:
        self.path = path
        self.count = count
        self.sync = sync
        self.full = False
        self.put_back = self.unsure = False
        self._key = ""
        self._elsewhere: NewestMark | None = None
        self._hash = last_hash
        self._lines: list[str] = []
        self._reserve = path.with_name("journal.reserve")
        try:
            self._reserve.write_bytes(b"\0" * RESERVE_BYTES)
            self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | BINARY, 0o644)
        except OSError as fault:
            raise JournalFault(f"cannot start the journal {path}: {fault.strerror}") from fault
        if count:
            self._look_elsewhere()
            self.unsure = self._elsewhere is not None and self._elsewhere.is_blank

    def _look_elsewhere(self) -> None:
        """A journal is known by its first record: a folder may have another name."""
        if not self.on_real_disk:
            return
        self._key = _hash_at(self.path, 1)[:12]
        self._elsewhere = NewestMark(self._key, file="journals")
        _, _, noted = self._elsewhere.read().partition(":")
        n, _, link = noted.partition(":")
        self.put_back = bool(n) and _hash_at(self.path, int(n)) != link

    def append(self, record: R) -> R:
        """Put a record into the buffer; it gets its number, time and hash, and is returned."""
        self.count += 1
        at = datetime.now(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
        rest = record.model_dump_json(exclude={"n", "at", "hash"}, exclude_none=True)
        body = f'{{"n":{self.count},"at":"{at}",{rest[1:-1]}'
        self._hash = chain(self._hash, body)
        self._lines.append(f'{body},"hash":"{self._hash}"}}\n')
        # Filled in, not copied: nobody has it before it is in the journal.
        vars(record).update(n=self.count, at=at, hash=self._hash)
        return record

    def flush(self) -> None:
        """Make every record appended so far durable; raises DiskFull if there is no space.

        After DiskFull the records are still on disk, in the space of the reserve.
        """
        if not self._lines:
            return
        data = "".join(self._lines).encode()
        start = os.fstat(self._file).st_size
        try:
            self._write(data)
        except OSError as fault:
            # The records stay in the buffer: those that follow are chained to them.
            os.ftruncate(self._file, start)
            if fault.errno not in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
                raise NotWritten(f"cannot write {self.path}: {fault.strerror}") from fault
            self._use_reserve(data, fault)
        self._lines.clear()
        if self._elsewhere is None:
            self._look_elsewhere()
        if self._elsewhere is not None:
            self._elsewhere.write(f"{self._key}:{self.count}:{self._hash}")

    def hand_over(self) -> None:
        """Give a lone record to the system without waiting for the disk: it survives this process.

        Where others wait before it, or the disk has no space, it waits for the next `flush`.
        """
        if len(self._lines) != 1:
            return
        start = os.fstat(self._file).st_size
        try:
            self._write(self._lines[0].encode(), sync=False)
        except OSError:
            os.ftruncate(self._file, start)
        else:
            self._lines.clear()

    def _use_reserve(self, data: bytes, fault: OSError) -> None:
        message = f"no space left for the journal {self.path}: {fault.strerror}"
        self.full = True
        if not self._reserve.exists():
            raise NotWritten(message) from fault
        remove(self._reserve)
        try:
            self._write(data)
        except OSError as again:
            raise NotWritten(message) from again
        self._lines.clear()
        raise DiskFull(message) from fault

    def _write(self, data: bytes, *, sync: bool = True) -> None:
        view = memoryview(data)
        while view:
            view = view[os.write(self._file, view) :]
        if sync and self.sync:
            os.fdatasync(self._file) if hasattr(os, "fdatasync") else sync_file(self._file)

    def close(self) -> None:
        """Write what is left and close the file."""
        try:
            self.flush()
        finally:
            os.close(self._file)
            remove(self._reserve)
            if self._elsewhere is not None:
                self._elsewhere.close()


class Follower:
    """Reads a journal as it grows: only new records; an incomplete last line waits for its end.

    With `kinds`, only records of these; of the others the chain is checked. It stops at a sector that
    a power cut has left empty: what follows was never durable.
    """

    def __init__(self, path: Path, *kinds: str) -> None:
        self.path = path
        self.offset = 0
        self.number = 0
        self.last_hash = ""
        self._kinds = tuple(f'"{kind}"'.encode() for kind in kinds)

    @property
    def behind(self) -> int:
        """Bytes that have not been read yet."""
        try:
            return self.path.stat().st_size - self.offset
        except OSError:
            return 0

    def records(self, most_bytes: int | None = None) -> Iterator[tuple[int, JournalRecord]]:
        """Every new record with the offset of its line; raises JournalFault, naming what is wrong.

        With `most_bytes` it ends after about that many, so that other tasks get their turn.
        """
        end = None if most_bytes is None else self.offset + most_bytes
        rest = b""
        try:
            with self.path.open("rb") as file:
                file.seek(self.offset)
                while chunk := file.read(CHUNK):
                    *lines, rest = (rest + chunk).split(b"\n")
                    for line in lines:
                        if b"\0" in line:
                            return
                        start, self.last_hash = self.offset, self._check(line)
                        self.offset += len(line) + 1
                        if not self._kinds or line.partition(KIND)[2].startswith(self._kinds):
                            yield start, self._parse(line)
                    if end is not None and self.offset >= end:
                        return
        except OSError as fault:
            text = f"cannot read the journal {self.path}: {fault.strerror}"
            raise JournalFault(text) from fault

    def _check(self, line: bytes) -> str:
        """The hash of a record, whose chain is right; raises JournalFault."""
        self.number += 1
        body, mark, tail = line.rpartition(b',"hash":"')
        if not mark or (link := _chain(self.last_hash, body)).encode() != tail.removesuffix(b'"}'):
            raise JournalFault(
                f"{self.path}: the chain breaks at record {self.number}: it, or a record before it, "
                "was changed. Nothing was sent. Restore the journal from a copy, or start a new run."
            )
        if self.number == 1 and (newer := _newer_format(body)):
            raise JournalFault(
                f"{self.path} is written in journal format {newer}; this labrun reads format "
                f"{FORMAT}. Resume it with the labrun that wrote it, or a newer one."
            )
        return link

    def _parse(self, line: bytes) -> JournalRecord:
        try:
            return RECORD.validate_json(line)
        except ValidationError as fault:
            words = f"{self.path}: record {self.number} cannot be understood: {first_fault(fault)}"
            if fault.errors()[0]["type"] in NEWER:
                words += ". A newer labrun has gone on with this run; resume it with that one."
            raise JournalFault(words) from fault


class Records:
    """The whole records of a journal, in order: read anew each time, so that a million take no memory.

    A torn end is left out. Raises JournalFault if the chain is broken, naming the record.
    """

    def __init__(self, path: Path, *kinds: str) -> None:
        self.path, self._kinds = path, kinds

    def of(self, *kinds: str) -> "Records":
        """Those of some kinds."""
        return Records(self.path, *kinds)

    def __repr__(self) -> str:
        return f"<records of {self.path}>"

    def __iter__(self) -> Iterator[JournalRecord]:
        return (record for _, record in Follower(self.path, *self._kinds).records())


def read_records(path: Path) -> Iterator[JournalRecord]:
    """Every whole record of a journal, in order, as `Records` gives them."""
    return iter(Records(path))


def read_at(path: Path, offsets: list[int]) -> list[JournalRecord]:
    """The records at these offsets."""
    found = []
    with path.open("rb") as file:
        for offset in offsets:
            file.seek(offset)
            found.append(RECORD.validate_json(file.readline()))
    return found


def read_between(path: Path, start: int, end: int) -> Iterator[JournalRecord]:
    """The records from one offset to another, inclusive."""
    with path.open("rb") as file:
        file.seek(start)
        at = start
        for line in file:
            if at > end or not line.endswith(b"\n"):
                return
            at += len(line)
            yield RECORD.validate_json(line)


def _hash_at(path: Path, n: int) -> str:
    """The hash of the n-th record; empty where there is none."""
    with path.open("rb") as file:
        line = next(islice(file, n - 1, n), b"")
    return line.rpartition(b',"hash":"')[2].removesuffix(b'"}\n').decode("ascii", errors="replace")


def _newer_format(body: bytes) -> int | None:
    import json

    written = json.loads(body + b"}").get("format", FORMAT)
    return written if written > FORMAT else None


def read_through(path: Path) -> Follower:
    """A follower that has gone through all whole records: how many, and the bytes behind."""
    follower = Follower(path, NONE)
    deque(follower.records(), maxlen=0)
    return follower


def reopen(path: Path, make: type[Journal] = Journal) -> tuple[Journal, Records, int]:
    """A journal to append to, its records, and how many bytes of a torn end were cut."""
    whole = read_through(path)
    torn = path.stat().st_size - whole.offset
    if torn:
        with path.open("r+b") as file:
            file.truncate(whole.offset)
            sync_file(file.fileno())
    journal = make(path, count=whole.number, last_hash=whole.last_hash)
    return journal, Records(path), torn
