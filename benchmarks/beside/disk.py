"""A folder on a real disk, and the name of the file system that it is on."""

import os
import tempfile
from pathlib import Path

IN_MEMORY = ("tmpfs", "ramfs")
MOUNTS = Path("/proc/mounts")


def file_system(path: Path) -> str:
    """The type of the file system that holds this path; `unknown` where the system has no list."""
    if not MOUNTS.exists():
        return "unknown"
    best, kind = "", "unknown"
    for line in MOUNTS.read_text(encoding="utf-8").splitlines():
        _, mount, type_, *_ = line.split()
        if len(mount) >= len(best) and path.resolve().is_relative_to(mount):
            best, kind = mount, type_
    return kind


def place_on_disk() -> Path:
    """Where temporary files lie on a disk: in memory an fsync would cost nothing."""
    for place in (Path(tempfile.gettempdir()), Path("/var/tmp"), Path.cwd()):
        if os.access(place, os.W_OK) and file_system(place) not in IN_MEMORY:
            return place
    raise SystemExit(
        "every folder tried is in memory, where an fsync costs nothing; set TMPDIR to one on a disk"
    )
