"""Files that are whole: a reader sees the old one or the new one, and a power cut leaves one of them."""

import errno
import os
import secrets
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from . import WINDOWS

try:
    import fcntl

    FULL_SYNC = getattr(fcntl, "F_FULLFSYNC", None)
    """macOS': it empties the cache of the disk, too."""
except ImportError:  # Windows
    FULL_SYNC = None

BINARY = getattr(os, "O_BINARY", 0)
"""A flag for `os.open`: without it Windows writes every line's end as two characters."""
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
"""A disk that takes no more."""
REFUSED = (*FULL, errno.EROFS, errno.EACCES, errno.EPERM, errno.ENAMETOOLONG)
"""What is no fault of a program: the disk, its owner or a name that it cannot have."""
FAR = 1 << 30
"""The byte that is locked on Windows: beyond the file's end, since nobody else may read a locked one."""
PAUSES_S = (0.001, 0.002, 0.005, 0.01, 0.02, *[0.05] * 100)
"""Between attempts while Windows refuses since another program has the old file open: 5 s in all."""


def write_whole(path: Path, data: bytes, *, mode: int | None = None, sync: bool = True) -> None:
    """Replace a file, or create it and its folders; on disk on return unless `sync` is off.

    A link is followed. Without a `mode`, a file that is replaced keeps its permissions. Raises
    OSError, and then the old file is as it was.
    """
    place = path.resolve()
    place.parent.mkdir(parents=True, exist_ok=True)
    half = place.with_name(f".{place.name}.{secrets.token_hex(4)}.part")
    try:
        with os.fdopen(_created(half, 0o666 if mode is None else mode), "wb") as file:
            file.write(data)
            if sync:
                file.flush()
                sync_file(file.fileno())
        if mode is None and place.exists():
            shutil.copymode(place, half)
        put(half, place)
    except OSError:
        remove(half)
        raise
    if sync:
        sync_folder(place.parent)


@contextmanager
def replace_whole(path: Path) -> Iterator[IO[bytes]]:
    """A file to write piece by piece that replaces `path` if the block succeeds; raises OSError."""
    place = path.resolve()
    half = place.with_name(f".{place.name}.{secrets.token_hex(4)}.part")
    try:
        with os.fdopen(_created(half, 0o666), "w+b") as file:
            yield file
            file.flush()
            sync_file(file.fileno())
        put(half, place)
    except BaseException:  # Ctrl-C as well: the half is of no use
        remove(half)
        raise


def _created(half: Path, mode: int) -> int:
    return os.open(half, os.O_RDWR | os.O_CREAT | os.O_EXCL | BINARY, mode)


def put(half: Path, place: Path) -> None:
    """Put a finished file in another's place; patient on Windows, where a virus scanner may hold one."""
    _patiently(lambda: half.replace(place))


def remove(path: Path) -> None:
    """Delete a file if it is there; as patient."""
    _patiently(lambda: path.unlink(missing_ok=True))


def _patiently(act: Callable[[], object]) -> None:
    for pause_s in PAUSES_S if WINDOWS else ():
        try:
            act()
            return
        except PermissionError:
            time.sleep(pause_s)
    act()


def lock_file(file: IO[str]) -> None:
    """Lock an open file until it is closed or the process dies; raises OSError if another has."""
    if WINDOWS:
        import msvcrt

        file.seek(FAR)
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
    else:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)  # pyright: ignore[reportPossiblyUnboundVariable]


def lock_of_this_computer(name: str) -> IO[str]:
    """A file by this name for `lock_file`, which programs of every user may lock; raises OSError."""
    path = Path(tempfile.gettempdir()) / f"labrun_{name}.lock"
    no_link = getattr(os, "O_NOFOLLOW", 0)
    try:
        return os.fdopen(
            os.open(path, os.O_RDWR | os.O_CREAT | no_link, 0o644), "r+", encoding="utf-8"
        )
    except PermissionError:  # it is another user's: to lock it, reading is enough
        return os.fdopen(os.open(path, os.O_RDONLY | no_link), encoding="utf-8")


def sync_file(descriptor: int) -> None:
    """Have what was written to a file on disk, after a power cut, too; raises OSError.

    `fsync` of macOS leaves it in the cache of the disk itself; some file systems know only that.
    """
    if FULL_SYNC is not None:
        with suppress(OSError):
            fcntl.fcntl(descriptor, FULL_SYNC)  # pyright: ignore[reportPossiblyUnboundVariable]
            return
    os.fsync(descriptor)


def sync_folder(folder: Path) -> None:
    """Make the names in a folder durable: without it, a power cut can lose a whole new file."""
    if WINDOWS:  # it has no such call, and does not need it
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        sync_file(descriptor)
    finally:
        os.close(descriptor)


def sync_files(folder: Path, *within: str) -> None:
    """Make a folder durable with the files in it and in folders within it, and its own name."""
    for inner in [folder / name for name in within if (folder / name).is_dir()]:
        _sync_files(inner)
    _sync_files(folder)
    sync_folder(folder.parent)


def _sync_files(folder: Path) -> None:
    for path in folder.iterdir():
        if path.is_file():
            # Windows makes durable only what may be written.
            descriptor = os.open(path, os.O_RDWR if WINDOWS else os.O_RDONLY)
            try:
                sync_file(descriptor)
            finally:
                os.close(descriptor)
    sync_folder(folder)
