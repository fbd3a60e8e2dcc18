"""Names of files in a run's folder, which never lead out of it."""

from pathlib import Path, PurePosixPath


class FileFault(ValueError):
    """A file of an action that cannot be read, written or trusted; the text says which and why."""


def inside(folder: Path, name: str) -> Path:
    """The path of a relative file name in the run's folder; refuses one that leads out of it."""
    pure = PurePosixPath(name.replace("\\", "/"))
    leads_out = not pure.parts or pure.is_absolute() or ".." in pure.parts or ":" in pure.parts[0]
    if leads_out or "\0" in name:
        raise FileFault(f"{name!r} is not a file name inside the run's folder")
    return folder / pure
