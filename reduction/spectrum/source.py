"""The complete bytes of a spectrum: a file that is still growing is refused."""

from pathlib import Path

from .fault import Unreadable


def bytes_of(source: Path | str | bytes) -> bytes:
    """The contents of a file, or the bytes themselves.

    Raises Unreadable if the file's size changes meanwhile (half a number would be a wrong one), or
    for a folder; OSError if the file cannot be opened.
    """
    if isinstance(source, bytes):
        return source
    path = Path(source)
    if path.is_dir():
        raise Unreadable(f"{path.name} is a folder; a spectrum is a file")
    before = path.stat().st_size
    raw = path.read_bytes()
    if not before == len(raw) == path.stat().st_size:
        raise Unreadable(f"{path.name} is still being written; read it again when it is complete")
    return raw
