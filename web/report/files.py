"""Every file of a run's folder with its size and sha256, checked against the journal."""

import hashlib
import os
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from ...engine.run.folder import SERVERS

PAGE = "report.html"
CRATE = "ro-crate-metadata.json"
WORKING_FILES = frozenset({"engine.lock", "control.json", "journal.reserve"})
"""Files of a running engine: they record nothing of the run, and one of them holds a token."""
HASHERS = 4
FORMATS = {
    ".yaml": "application/yaml", ".yml": "application/yaml", ".json": "application/json",
    ".jsonl": "application/jsonl", ".csv": "text/csv", ".tsv": "text/tab-separated-values",
    ".txt": "text/plain", ".log": "text/plain", ".md": "text/markdown", ".html": "text/html",
    ".png": "image/png", ".jpg": "image/jpeg", ".jpeg": "image/jpeg", ".svg": "image/svg+xml",
    ".tif": "image/tiff", ".tiff": "image/tiff", ".pdf": "application/pdf",
    ".npy": "application/octet-stream", ".npz": "application/zip", ".h5": "application/x-hdf5",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class KeptFile:
    """One file on disk; `told` is its sha256 in the journal."""

    path: str
    size: int = 0
    sha256: str = ""
    told: str = ""
    fault: str = ""

    @property
    def changed(self) -> bool:
        """True for a file that is not what the run wrote."""
        return bool(self.told and self.sha256 and self.told != self.sha256)

    @property
    def format(self) -> str:
        """The media type, by the file name's suffix."""
        return FORMATS.get(PurePosixPath(self.path).suffix.lower(), "application/octet-stream")


@dataclass(slots=True)
class Inventory:
    """The files of a folder, those in the journal that are missing, and those left out."""

    files: list[KeptFile] = field(default_factory=list)
    missing: list[KeptFile] = field(default_factory=list)
    working: list[KeptFile] = field(default_factory=list)

    @property
    def changed(self) -> list[KeptFile]:
        """Files that are not what the run wrote."""
        return [file for file in self.files if file.changed]


def take_inventory(folder: Path, told: Mapping[str, str]) -> Inventory:
    """Hash every file that belongs to the run's record; `told` is path -> sha256 in the journal.

    The report and the crate, which are made from this, and the working state of the engine and the
    device servers are left out.
    """
    inventory = Inventory()
    paths: list[str] = []
    for path in walk(folder):
        if path in (PAGE, CRATE):
            continue
        if is_working(path):
            inventory.working.append(KeptFile(path, _size(folder / path)))
        else:
            paths.append(path)
    with ThreadPoolExecutor(HASHERS) as pool:  # hashing releases the GIL
        inventory.files = list(pool.map(lambda path: look(folder, path, told.get(path, "")), paths))
    found = set(paths)
    inventory.missing = [
        KeptFile(path, told=digest) for path, digest in sorted(told.items()) if path not in found
    ]
    return inventory


def walk(folder: Path) -> Iterator[str]:
    """Names of the files below a folder, the top first, each folder sorted; links to other folders
    are not followed."""
    for place, folders, names in os.walk(folder):
        folders.sort()
        below = Path(place).relative_to(folder)
        for name in sorted(names):
            if (Path(place) / name).is_file():
                yield (below / name).as_posix()


def is_working(path: str) -> bool:
    """True for files that an engine or a device server needs only while it runs."""
    pure = PurePosixPath(path)
    half = pure.name.startswith(".") and pure.name.endswith(".part")
    return pure.parts[0] == SERVERS or path in WORKING_FILES or half


def look(folder: Path, path: str, told: str = "") -> KeptFile:
    """Current size and sha256 of one file."""
    try:
        with (folder / path).open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
            return KeptFile(path, os.fstat(file.fileno()).st_size, digest, told)
    except OSError as fault:
        return KeptFile(path, told=told, fault=f"cannot be read: {fault.strerror}")


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0
