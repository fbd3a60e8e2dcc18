"""Whether a disk has room for a run, asked before it begins."""

import shutil
from pathlib import Path

LEAST_ROOM = 20_000_000
"""Bytes that must be left: for a journal, a few spectra and a report."""


def no_room(folder: Path) -> str:
    """Why the disk of a folder takes no run; empty if it does, or cannot be asked."""
    there = next((path for path in (folder, *folder.parents) if path.exists()), folder)
    try:
        free = shutil.disk_usage(there).free
    except OSError:
        return ""
    left = f"{free / 1e6:.1f} MB left; a run needs {LEAST_ROOM / 1e6:g} MB at least"
    return f"the disk of {folder} has {left}" if free < LEAST_ROOM else ""
