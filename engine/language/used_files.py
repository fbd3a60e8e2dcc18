"""Files that a protocol names: beside the protocol, or among the copies that a run keeps.

A run's folder holds `used.json`, which maps the names in each copied file to their copies.
"""

import json
from collections.abc import Sequence
from pathlib import Path

from .suggest import closest

USED = "used.json"
COPIES = "used"


class FileFault(ValueError):
    """A file that cannot be read; the message says which and why."""


def find_file(
    protocol: Path, name: str, largest: int, folders: Sequence[Path]
) -> tuple[Path, bytes]:
    """The path and the bytes of a file that a protocol names; raises FileFault.

    It lies in one of `folders` or below: what a protocol names is copied into its runs, and
    everyone who may look at these sees it.
    """
    if not name:
        raise FileFault("no file is named")
    path = place_of(protocol, name)
    try:
        real = path.resolve()
        if not any(real.is_relative_to(folder.resolve()) for folder in folders):
            raise FileFault(
                f"{name} lies outside the protocol's folder; put it there, or list its folder "
                "under `folders:` in the lab"
            )
        if path.is_dir():
            raise FileFault(f"{name} is a folder, not a file")
        if not path.is_file():
            raise FileFault(f"there is no file {name} beside {protocol.name}{_guess(path)}")
        size = path.stat().st_size
        if size > largest:
            raise FileFault(
                f"{name} has {size / 1e6:,.0f} MB; the limit is {largest / 1e6:,.0f} MB"
            )
        return path, path.read_bytes()
    except (OSError, ValueError) as fault:
        if isinstance(fault, FileFault):
            raise
        reason = getattr(fault, "strerror", None) or fault
        raise FileFault(f"{name} cannot be read: {reason}") from fault


def place_of(protocol: Path, name: str) -> Path:
    """The path that a name in a protocol means: the run's own copy where there is one."""
    for folder in (protocol.parent, protocol.parent.parent):
        kept = kept_names(folder)
        if kept is not None:
            own = protocol.relative_to(folder).as_posix()
            copy = kept.get(own, {}).get(name)
            return folder / copy if copy is not None else protocol.parent / name
    return protocol.parent / name


def kept_names(folder: Path) -> dict[str, dict[str, str]] | None:
    """By protocol in a run's folder, what each name in it means there; None if it is no such folder."""
    try:
        kept = json.loads((folder / USED).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    is_ours = isinstance(kept, dict) and all(isinstance(names, dict) for names in kept.values())
    return kept if is_ours else None


def _guess(path: Path) -> str:
    slashed = path.name.replace("\\", "/")  # as Windows writes it, which is a name elsewhere
    if slashed != path.name and (path.parent / slashed).is_file():
        return f"; did you mean {slashed}?"
    try:
        near = closest(path.name, (entry.name for entry in path.parent.iterdir()))
    except OSError:
        return ""
    return f"; did you mean {near}?" if near else ""
