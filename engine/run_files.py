"""Files that travel with goals: read from the run's folder, written into it, never outside."""

import os
from hashlib import sha256
from pathlib import Path, PurePosixPath

from ..schemas.messages import FileContent


class FileFault(ValueError):
    """A file of an action that cannot be read, written or trusted; the text says which and why."""


def inside(folder: Path, name: str) -> Path:
    """The place of a relative file name in the run's folder; refuses one that leads out of it."""
    pure = PurePosixPath(name.replace("\\", "/"))
    leads_out = not pure.parts or pure.is_absolute() or ".." in pure.parts or ":" in pure.parts[0]
    if leads_out or "\0" in name:
        raise FileFault(f"{name!r} is not a file name inside the run's folder")
    return folder / pure


def read_content(folder: Path, name: str) -> FileContent:
    """A file of the run's folder as it goes to a device."""
    try:
        data = inside(folder, name).read_bytes()
    except FileNotFoundError as fault:
        raise FileFault(f"{name} is not in the run's folder") from fault
    except OSError as fault:
        raise FileFault(f"{name} cannot be read: {fault.strerror}") from fault
    return FileContent(path=name, sha256=sha256(data).hexdigest(), data=data)


def write_content(folder: Path, content: FileContent, *, sync: bool = True) -> str:
    """Write a file that came with a result; durable, and whole or not at all.

    Returns its sha256. Raises FileFault where content and hash disagree, OSError where the disk
    does not take it.
    """
    digest = sha256(content.data).hexdigest()
    if digest != content.sha256:
        raise FileFault(f"{content.path} was damaged on its way: its sha256 does not fit")
    place = inside(folder, content.path)
    place.parent.mkdir(parents=True, exist_ok=True)
    half = place.with_name(f".{place.name}.part")
    try:
        with half.open("wb") as file:
            file.write(content.data)
            if sync:
                file.flush()
                os.fsync(file.fileno())
        half.replace(place)
        if sync:
            sync_folder(place.parent)
    except OSError:
        half.unlink(missing_ok=True)
        raise
    return digest


def sync_folder(folder: Path) -> None:
    """Make the names in a folder durable: without it, a power cut can lose a whole new file."""
    if os.name == "nt":  # Windows has no such call, and does not need it
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
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
            descriptor = os.open(path, os.O_RDONLY)
            try:
                os.fsync(descriptor)
            finally:
                os.close(descriptor)
    sync_folder(folder)
