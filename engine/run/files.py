"""Files that travel with goals: read from the run's folder, written into it, never outside."""

from hashlib import sha256
from pathlib import Path, PurePosixPath

from ...schemas.messages import FileContent
from ...system.files import write_whole


class NoRoom(Exception):
    """The run's folder cannot be written to; the message names what, and why."""


class FileFault(ValueError):
    """A file of an action that cannot be read, written or trusted; the text says which and why."""


def inside(folder: Path, name: str) -> Path:
    """The path of a relative file name in the run's folder; refuses one that leads out of it."""
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

    Returns its sha256. Raises FileFault if content and hash disagree, OSError if the disk
    refuses it.
    """
    digest = sha256(content.data).hexdigest()
    if digest != content.sha256:
        raise FileFault(f"{content.path} was damaged in transit: its sha256 does not match")
    write_whole(inside(folder, content.path), content.data, sync=sync)
    return digest
