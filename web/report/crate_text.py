"""The crate's descriptions of itself, its licence and each file; how entities are named."""

import os
from collections.abc import Iterable
from typing import Any
from urllib.parse import quote

from ...engine.run.snapshots import FOLDER as SNAPSHOTS
from .files import CRATE, PAGE, KeptFile
from .formatting import local_time

Entity = dict[str, Any]

SPECIFICATION = "https://w3id.org/ro/crate/1.1"
PROFILE = "https://w3id.org/ro/wfrun/process/0.5"
ABOUT = (
    "The folder of a labrun run. Not part of this crate: the folder servers/ (ledgers, logs and the "
    "simulated world of the run's own device servers), engine.lock and control.json, which are working "
    f"state, and {CRATE} itself."
)
LICENCE = {
    "name": "No licence stated",
    "description": "labrun does not know the terms of use of this data: ask the people who made it.",
}
FOLDERS = {
    "contracts": "The device contracts at the start of the run",
    "snapshots": "Pictures that people took of the bench into the run",
    "spectra": "Spectra, one file per measurement",
}
FILES = {
    "lab.yaml": "The lab at the start of the run: its devices, drivers and limits",
    "run.json": "The command line of the run: file, parameters, roles",
    "journal.jsonl": "The append-only record of the run; a hash chains each line to the previous one",
    "data.csv": "The rows that the protocol collected, one per iteration",
    PAGE: "The run's report for people",
}
CHANGED = " Changed since the run wrote it: the sha256 in the journal is {}."


def described(file: KeptFile, writer: str, protocol_name: str) -> str:
    """What a file is, as far as the run knows."""
    told = FILES.get(file.path, "")
    if file.path == protocol_name:
        told = "The protocol at the start of the run"
    elif writer:
        told = f"Delivered by {writer}"
    elif file.path.startswith(f"{SNAPSHOTS}/"):
        told = (
            told or "Taken by a person: snapshots.jsonl says by whom, when, and with which camera"
        )
    elif file.format.startswith("image/"):
        told = told or "A figure, drawn from the run's rows"
    if file.changed:
        told += CHANGED.format(file.told)
    return f"{told} {file.fault}".strip()


def name_of(path: str) -> str:
    """A file's name as an identifier: percent-encoded, byte by byte if it is not UTF-8."""
    return quote(os.fsencode(path))


def ref(identifier: str) -> Entity:
    """A reference to another entity."""
    return {"@id": identifier}


def refs(identifiers: Iterable[str]) -> Entity | list[Entity]:
    """References to several entities; a single one is not a list, as RO-Crate recommends."""
    found = [ref(identifier) for identifier in identifiers]
    return found[0] if len(found) == 1 else found


def time(at: str) -> str:
    """ISO 8601 with an offset, as the profile requires."""
    moment = local_time(at)
    return moment.isoformat(timespec="milliseconds" if moment.microsecond else "seconds")
