"""A disk that a power cut robs of what was not synced: any sectors of it, in any order.

The ledger lies on it by way of a VFS of SQLite, the journal by its own writer.
"""

import asyncio
import contextlib
import errno
import itertools
import os
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import apsw

from ...drivers.server.ledger import TABLES, Ledger, LedgerFault
from ...schemas import journal as j
from ..journal.journal import Journal, JournalFault, R
from .process import Died, Process, living

SECTOR = 512


class File:
    """A file as programs see it (`data`), and as the disk has it (`synced`)."""

    def __init__(self, data: bytes = b"") -> None:
        self.data, self.synced = bytearray(data), bytearray(data)
        self.pending: list[tuple[int, bytes]] = []

    def write(self, data: bytes, offset: int) -> None:
        """As `pwrite`."""
        _put(self.data, data, offset)
        self.pending.append((offset, bytes(data)))

    def truncate(self, size: int) -> None:
        """As `ftruncate`; durable at once, which SQLite does not rely on."""
        del self.data[size:], self.synced[size:]
        self.pending = [(at, data) for at, data in self.pending if at < size]

    def sync(self) -> None:
        """As `fsync`."""
        for offset, data in self.pending:
            _put(self.synced, data, offset)
        self.pending.clear()

    def lose(self, random: Random) -> None:
        """A power cut: of what was not synced, some sectors are on the disk, and some are not."""
        share = random.choice((0.0, 0.5, 0.9, 1.0))
        for offset, data in self.pending:
            for start, end in _sectors(offset, len(data)):
                if random.random() < share:
                    _put(self.synced, data[start - offset : end - offset], start)
        self.pending.clear()
        self.data = bytearray(self.synced)


def _put(whole: bytearray, data: bytes, offset: int) -> None:
    if offset > len(whole):
        whole.extend(bytes(offset - len(whole)))
    whole[offset : offset + len(data)] = data


def _sectors(offset: int, size: int) -> list[tuple[int, int]]:
    """(start, end) of every sector, or part of one, that a write touches."""
    starts = [offset, *range(offset - offset % SECTOR + SECTOR, offset + size, SECTOR)]
    return list(zip(starts, [*starts[1:], offset + size], strict=True))


class Disk:
    """The files of one device server; a ledger is opened on the disk of the process that opens it."""

    def __init__(self) -> None:
        self.files: dict[str, File] = {}
        self.full_until = 0.0

    @property
    def is_full(self) -> bool:
        """Whether it takes nothing at present."""
        return asyncio.get_running_loop().time() < self.full_until

    def lose(self, random: Random) -> None:
        """A power cut."""
        for file in self.files.values():
            file.lose(random)

    def copy(self) -> dict[str, bytes]:
        """What somebody copies who copies its files."""
        return {name: bytes(file.data) for name, file in self.files.items()}

    def put_back(self, copied: dict[str, bytes]) -> None:
        """Replace everything by a copy."""
        self.files = {name: File(data) for name, data in copied.items()}


class _Handle:
    def __init__(self, file: File, process: "OnDisk") -> None:
        self.file, self.process = file, process

    def xRead(self, amount: int, offset: int) -> bytes:  # noqa: N802 - SQLite's names
        return bytes(self.file.data[offset : offset + amount])

    def xWrite(self, data: bytes, offset: int) -> None:  # noqa: N802
        if self.process.alive:
            if self.process.disk.is_full and offset + len(data) > len(self.file.data):
                raise apsw.FullError("database or disk is full")
            self.file.write(data, offset)

    def xTruncate(self, size: int) -> None:  # noqa: N802
        if self.process.alive:
            self.file.truncate(size)

    def xSync(self, flags: int) -> None:  # noqa: N802
        if self.process.alive:
            self.file.sync()

    def xFileSize(self) -> int:  # noqa: N802
        return len(self.file.data)

    def xSectorSize(self) -> int:  # noqa: N802
        return SECTOR

    def xDeviceCharacteristics(self) -> int:  # noqa: N802
        return apsw.SQLITE_IOCAP_POWERSAFE_OVERWRITE

    def xFileControl(self, op: int, pointer: int) -> bool:  # noqa: N802
        return False

    def xCheckReservedLock(self) -> bool:  # noqa: N802
        return False

    def xLock(self, level: int) -> None:  # noqa: N802
        pass

    def xUnlock(self, level: int) -> None:  # noqa: N802
        pass

    def xClose(self) -> None:  # noqa: N802
        pass


class _Vfs(apsw.VFS):
    """Names begin with the number of the process whose disk they are on."""

    def __init__(self) -> None:
        super().__init__(NAME, base="")

    def xOpen(self, name: Any, flags: list[int]) -> Any:  # noqa: N802
        process, path = _on_disk(name if isinstance(name, str) else name.filename())
        flags[1] = flags[0]
        return _Handle(process.disk.files.setdefault(path, File()), process)

    def xFullPathname(self, name: str) -> str:  # noqa: N802
        return name

    def xAccess(self, pathname: str, flags: int) -> bool:  # noqa: N802
        process, name = _on_disk(pathname)
        return name in process.disk.files

    def xDelete(self, filename: str, syncdir: bool) -> None:  # noqa: N802
        process, name = _on_disk(filename)
        if process.alive:
            process.disk.files.pop(name, None)


class OnDisk(Process):
    """A process with a disk."""

    def __init__(self, disk: Disk) -> None:
        super().__init__()
        self.disk = disk
        self.connections: list[apsw.Connection] = []
        self.number = next(_numbers)
        _processes[self.number] = self

    def bury_files(self) -> None:
        """Forget it; what it had open has no effect any more."""
        self.alive = False
        for connection in self.connections:
            with contextlib.suppress(apsw.FullError):
                connection.close()
        _processes.pop(self.number, None)


def _on_disk(path: str) -> tuple[OnDisk, str]:
    number, _, name = path.partition("-")
    return _processes[int(number)], name


NAME = "labrun-simulated"
_numbers = itertools.count()
_processes: dict[int, OnDisk] = {}
VFS = _Vfs()


class SimulatedLedger(Ledger):
    """The ledger on the simulated disk; a sync takes some milliseconds, and the order is kept."""

    on_real_disk = False

    def __init__(self, random: Random) -> None:
        self._random = random
        self._free_at = 0.0
        self._process = living()
        super().__init__(Path("ledger.sqlite"))

    def _open(self) -> Any:
        assert isinstance(self._process, OnDisk)
        disk = apsw.Connection(f"{self._process.number}-ledger.sqlite", vfs=NAME)
        self._process.connections.append(disk)
        for pragma in ("locking_mode = EXCLUSIVE", "journal_mode = WAL", "synchronous = FULL"):
            disk.execute(f"PRAGMA {pragma}").fetchall()
        disk.execute(TABLES)
        return disk

    @contextlib.contextmanager
    def writing(self) -> Iterator[None]:
        try:
            with super().writing():
                yield
        except apsw.Error as fault:
            raise LedgerFault(f"the ledger {self.path} cannot be written: {fault}") from fault

    def queued(self, work: Any, *args: Any) -> asyncio.Future[Any]:
        loop = asyncio.get_running_loop()
        done = loop.create_future()
        self._free_at = max(self._free_at, loop.time()) + self._random.uniform(0.0001, 0.01)
        loop.call_at(self._free_at, self._work, done, work, args)
        return done

    def _work(self, done: asyncio.Future[Any], work: Any, args: tuple[Any, ...]) -> None:
        if not self._process.alive or done.cancelled():
            return
        try:
            done.set_result(work(*args))
        except Exception as fault:  # it is raised where the work is awaited
            done.set_exception(fault)

    def close(self) -> None:
        with contextlib.suppress(apsw.FullError):  # what was not moved out of the log stays there
            self._disk.close()


class SimulatedJournal(Journal):
    """A journal that says how much of it is on the disk, and may be the last thing an engine does.

    `doom`: the process dies at its next write: `before` it, with `half` of it, or `after` it.
    `full_until`: until then the disk has only the journal's own reserve left.
    """

    on_real_disk = False
    doom = ""
    full_until = 0.0
    lengths: dict[Path, int] = {}  # noqa: RUF012 - by path, for the power cuts of every history
    sent_s: dict[str, float] = {}  # noqa: RUF012 - when each goal was announced, by no clock that is set

    def __init__(self, path: Path, **more: Any) -> None:
        self._process = living()
        if _is_full():
            raise JournalFault(f"cannot start the journal {path}: {os.strerror(errno.ENOSPC)}")
        super().__init__(path, **more)
        SimulatedJournal.lengths.setdefault(path, path.stat().st_size)

    def append(self, record: R) -> R:
        if isinstance(record, j.GoalSent):
            self.sent_s[record.id] = asyncio.get_running_loop().time()
        return super().append(record)

    def _write(self, data: bytes, *, sync: bool = True) -> None:
        self._process.check()
        if _is_full() and self._reserve.exists():
            os.write(self._file, data[: len(data) // 2])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        doom, SimulatedJournal.doom = SimulatedJournal.doom, ""
        if doom in ("before", "half"):
            os.write(self._file, data[: len(data) // 2 if doom == "half" else 0])
        else:
            os.write(self._file, data)
            if sync:
                SimulatedJournal.lengths[self.path] = os.fstat(self._file).st_size
        if doom:
            self._process.kill()
            raise Died


def _is_full() -> bool:
    return asyncio.get_running_loop().time() < SimulatedJournal.full_until


def lose_journal(path: Path, random: Random) -> None:
    """A power cut: of the journal's unsynced end some sectors are there, others are zeros or gone."""
    synced = SimulatedJournal.lengths.get(path, 0)
    file = File(path.read_bytes())
    end = bytes(file.data[synced:])
    del file.synced[synced:]
    file.pending = [(synced, end)] if end else []
    file.lose(random)
    path.write_bytes(file.data)
    SimulatedJournal.lengths[path] = len(file.data)
