"""Pictures that people took of the bench into a run, each with its time, device and person."""

import os
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path

from pydantic import ValidationError

from ...schemas.snapshot import Snapshot
from ...system.files import write_whole

FOLDER = "snapshots"
RECORD = f"{FOLDER}/snapshots.jsonl"


def add_snapshot(folder: Path, picture: bytes, suffix: str, device: str, by: str) -> Snapshot:
    """Keep a picture in a run's folder, then its line in the record; raises OSError."""
    at = datetime.now(UTC)
    stem, n = f"{FOLDER}/{at:%Y%m%dT%H%M%S}_{device}", 1
    name = f"{stem}{suffix}"
    while (folder / name).exists():
        n += 1
        name = f"{stem}_{n}{suffix}"
    (folder / FOLDER).mkdir(exist_ok=True)
    write_whole(folder / name, picture, mode=0o644)
    told = Snapshot(
        file=name, device=device, by=by, at=at.isoformat(timespec="seconds"),
        sha256=sha256(picture).hexdigest(),
    )  # fmt: skip
    with (folder / RECORD).open("ab") as record:
        torn = record.tell() > 0 and (folder / RECORD).read_bytes()[-1:] != b"\n"
        record.write(b"\n" * torn + told.model_dump_json().encode() + b"\n")
        record.flush()
        os.fsync(record.fileno())
    return told


def read_snapshots(folder: Path) -> list[Snapshot]:
    """Those that are there, oldest first; a line that cannot be read is left out."""
    try:
        lines = (folder / RECORD).read_bytes().splitlines()
    except OSError:
        return []
    found: list[Snapshot] = []
    for line in lines:
        try:
            found.append(Snapshot.model_validate_json(line))
        except ValidationError:
            continue
    return [one for one in found if (folder / one.file).is_file()]
