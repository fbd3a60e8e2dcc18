"""Everything that a report is made from: the journal, inputs and files of one run's folder."""

import os
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from ...engine.run.folder import engine_of, is_live
from ...engine.run.snapshots import read_snapshots
from ...schemas.snapshot import Snapshot
from .counts import JournalDigest
from .files import Inventory, KeptFile, take_inventory
from .inputs import Inputs, read_inputs
from .journal_digest import read_digest
from .versions import installed_versions, machine

PICTURES = ("image/png", "image/jpeg", "image/svg+xml")


@dataclass(slots=True)
class ReportData:
    """One run, read."""

    folder: Path
    digest: JournalDigest
    inputs: Inputs
    inventory: Inventory
    fate: str
    made_at: str
    figures: list[KeptFile] = field(default_factory=list)
    snapshots: list[Snapshot] = field(default_factory=list)
    stale_tables: list[str] = field(default_factory=list)
    versions: dict[str, str] = field(default_factory=dict)
    machine: str = ""

    @property
    def name(self) -> str:
        """The protocol's name."""
        started = self.digest.started
        return started.protocol if started is not None else self.folder.name

    @property
    def roles(self) -> dict[str, str]:
        """Role -> device."""
        return self.digest.started.roles if self.digest.started is not None else {}


def gather(folder: Path) -> ReportData:
    """Read a run's folder; damage becomes a sentence in the report, not an exception."""
    folder = folder.resolve()
    live = _is_run_by_another(folder)
    digest = read_digest(folder, live=live)
    inventory = take_inventory(folder, digest.files)
    return ReportData(
        folder=folder, digest=digest, inputs=read_inputs(folder), inventory=inventory,
        fate=_fate(digest, live=live), figures=_figures(inventory), snapshots=read_snapshots(folder),
        stale_tables=_stale_tables(folder, digest), made_at=datetime.now(UTC).isoformat(timespec="seconds"),
        versions=installed_versions(), machine=machine(),
    )  # fmt: skip


def _fate(digest: JournalDigest, *, live: bool) -> str:
    if digest.finished is not None:
        return digest.finished.fate
    return "running" if live else "interrupted"


def _figures(inventory: Inventory) -> list[KeptFile]:
    """Image files beside the journal."""
    top = (file for file in inventory.files if "/" not in file.path)
    return [file for file in top if file.format in PICTURES]


def _stale_tables(folder: Path, digest: JournalDigest) -> list[str]:
    """Tables that do not match the journal's rows.

    None while a run is unfinished: resume rewrites them from the journal.
    """
    if digest.finished is None:
        return []
    return [name for name, told in digest.tables.items() if not told.fits(folder / name)]


def _is_run_by_another(folder: Path) -> bool:
    """True while another engine holds the run; not for the one making this report at the run's end."""
    if not is_live(folder):
        return False
    return engine_of(folder) != os.getpid()
