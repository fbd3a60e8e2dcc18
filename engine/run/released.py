"""What a person has released to be started by a program: all that the run will use, copied beforehand.

A release lies in the folder of the runs, as `.released/ID/`, made as a run's own copies are: what is
changed afterwards is not run. One start uses it up.
"""

import json
from hashlib import sha256
from pathlib import Path

from pydantic import Field, ValidationError

from ...schemas.model import Model
from ...system.files import put
from ..lab.lab import LoadedLab
from .folder import FolderFault

FOLDER = ".released"
RECORD = "release.json"
USED_UP = "started"


class Release(Model):
    """A release: `sha256` is of the protocol's text, `lab` of the lab with its contracts."""

    id: str
    file: str
    protocol: str
    sha256: str
    lab: str
    params: dict[str, str]
    roles: dict[str, str]
    by: str
    at: str
    checklist: list[str] = Field(default_factory=list)
    """What was ticked on the page."""


def lab_digest(lab: LoadedLab) -> str:
    """The same for the same lab: its devices, limits and contracts."""
    said = [lab.lab.model_dump(mode="json")]
    said += [lab.contracts[name].model_dump(mode="json") for name in sorted(lab.contracts)]
    return sha256(json.dumps(said).encode()).hexdigest()


def releases(runs: Path) -> list[Release]:
    """Those that nobody has started yet, oldest first."""
    found = [_read(path) for path in (runs / FOLDER).glob(f"*/{RECORD}")]
    return sorted((one for one in found if one is not None), key=lambda one: one.at)


def take(runs: Path, id: str) -> tuple[Release, Path]:
    """Use up a release, which only one caller can: it, and its folder; raises FolderFault."""
    release = next((one for one in releases(runs) if one.id == id), None)
    folder = runs / FOLDER / id
    taken = runs / FOLDER / f"{id}-{USED_UP}"
    try:
        if release is None:
            raise FileNotFoundError
        put(folder / RECORD, folder / f"{USED_UP}.json")
        put(folder, taken)
    except OSError:
        raise FolderFault(
            f"nobody has released {id!r}, or it was started already: a person releases a protocol "
            "on the page, or with `labrun release FILE -p NAME=VALUE`, for one start"
        ) from None
    return release, taken


def put_back(taken: Path) -> None:
    """Undo `take` where no run came of it."""
    folder = taken.with_name(taken.name.removesuffix(f"-{USED_UP}"))
    put(taken, folder)
    put(folder / f"{USED_UP}.json", folder / RECORD)


def _read(path: Path) -> Release | None:
    try:
        release = Release.model_validate_json(path.read_bytes())
    except (OSError, ValidationError):
        return None
    return release if release.id == path.parent.name else None
