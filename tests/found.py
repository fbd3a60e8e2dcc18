"""A file below a folder in which processes make folders and remove them again."""

import os
from pathlib import Path


def found(folder: Path, pattern: str) -> Path | None:
    """The first file that matches; `rglob` of Python 3.11 trips over a folder that goes meanwhile."""
    files = (Path(at, name) for at, _, names in os.walk(folder) for name in names)
    return next((path for path in files if path.match(pattern)), None)
