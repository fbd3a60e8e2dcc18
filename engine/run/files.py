"""Files that travel with goals: read from the run's folder, written into it, never outside."""

from hashlib import sha256
from pathlib import Path

from ...schemas.messages import FileContent
from ...system.files import write_whole
from ..language.used_files import kept_names
from .names import FileFault, inside


class NoRoom(Exception):
    """The run's folder cannot be written to; the message names what, and why."""


def read_content(folder: Path, name: str) -> FileContent:
    """A file of the run's folder as it goes to a device, or its copy of what was beside the protocol."""
    try:
        path = inside(folder, name)
        data = (path if path.is_file() else _copy(folder, name) or path).read_bytes()
    except FileNotFoundError as fault:
        raise FileFault(f"{name} is not in the run's folder") from fault
    except OSError as fault:
        raise FileFault(f"{name} cannot be read: {fault.strerror}") from fault
    return FileContent(path=name, sha256=sha256(data).hexdigest(), data=data)


def _copy(folder: Path, name: str) -> Path | None:
    """What a name of the run's protocols means among its copies."""
    found = {kept[name] for kept in (kept_names(folder) or {}).values() if name in kept}
    if len(found) > 1:
        raise FileFault(
            f"{name} is another file in each of the protocols; give them different names"
        )
    return folder / found.pop() if found else None


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
