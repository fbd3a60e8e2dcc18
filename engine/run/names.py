"""Names of files in a run's folder: they never lead out of it, and are those of files."""

from pathlib import Path, PurePosixPath

from ...system import NO_FILE, WINDOWS


class FileFault(ValueError):
    """A file of an action that cannot be read, written or trusted; the text says which and why."""


class NoFileName(FileFault):
    """A name that no file has on this system, or on Windows as far as a drive goes."""


def inside(folder: Path, name: str) -> Path:
    """The path of a relative file name in the run's folder; refuses one that leads out of it.

    On Windows it also refuses a name that no file has there.
    """
    pure = PurePosixPath(name.replace("\\", "/"))
    leads_out = not pure.parts or pure.is_absolute() or ".." in pure.parts
    if not leads_out and ":" in pure.parts[0]:
        leads_out = len(pure.parts[0]) == 2
        if not leads_out:
            raise NoFileName(
                f"{name!r}: a colon names a drive on Windows; write another sign, such as -"
            )
    if leads_out or "\0" in name:
        raise FileFault(f"{name!r} is not a file name inside the run's folder")
    refused = next((part for part in pure.parts if NO_FILE.search(part)), None) if WINDOWS else None
    if refused is not None:
        raise NoFileName(f"{name!r}: on Windows no file can be named {refused!r}")
    return folder / pure
