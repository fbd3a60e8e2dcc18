"""One file to be reduced, and its name in the tables."""

import os
import re
from dataclasses import dataclass
from pathlib import Path

NUMBER = re.compile(r"([0-9]+)")


@dataclass(frozen=True, slots=True)
class Source:
    """name: the path relative to the given folder, with slashes on every system."""

    name: str
    path: Path


def source(path: Path, root: Path) -> Source:
    """The file with its name relative to `root`; the whole path if it is elsewhere."""
    below = Path(os.path.relpath(path, root)) if path.is_relative_to(root) else path
    # A name that is not UTF-8 is legal on disk, but not in a table.
    return Source(os.fsencode(below.as_posix()).decode("utf-8", "backslashreplace"), path)


def natural(name: str) -> tuple[list[tuple[int, str]], str]:
    """Natural sort order: `core_2` comes before `core_10`."""
    parts = NUMBER.split(name)
    return [(int(p), "") if NUMBER.fullmatch(p) else (-1, p) for p in parts], name
