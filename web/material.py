"""Everything that a report is made from: the story, the inputs and the files of one run's folder."""

import os
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from ..engine.run_folder import FolderLock, is_live
from .files import Inventory, KeptFile, take_inventory
from .inputs import Inputs, read_inputs
from .story import read_story
from .tally import Story
from .versions import installed_versions, machine

PICTURES = ("image/png", "image/jpeg", "image/svg+xml")


@dataclass(slots=True)
class Material:
    """One run, read."""

    folder: Path
    story: Story
    inputs: Inputs
    inventory: Inventory
    fate: str
    made_at: str
    figures: list[KeptFile] = field(default_factory=list)
    stale_tables: list[str] = field(default_factory=list)
    versions: dict[str, str] = field(default_factory=dict)
    machine: str = ""

    @property
    def name(self) -> str:
        """What the protocol is called."""
        started = self.story.started
        return started.protocol if started is not None else self.folder.name

    @property
    def roles(self) -> dict[str, str]:
        """Role -> device."""
        return self.story.started.roles if self.story.started is not None else {}


def gather(folder: Path) -> Material:
    """Read a run's folder; whatever is damaged in it becomes a sentence, not a fault."""
    folder = folder.resolve()
    live = _is_run_by_another(folder)
    story = read_story(folder, live=live)
    inventory = take_inventory(folder, story.files)
    return Material(
        folder=folder, story=story, inputs=read_inputs(folder), inventory=inventory,
        fate=_fate(story, live=live), figures=_figures(inventory),
        stale_tables=_stale_tables(folder, story), made_at=datetime.now(UTC).isoformat(timespec="seconds"),
        versions=installed_versions(), machine=machine(),
    )  # fmt: skip


def _fate(story: Story, *, live: bool) -> str:
    if story.finished is not None:
        return story.finished.fate
    return "running" if live else "interrupted"


def _figures(inventory: Inventory) -> list[KeptFile]:
    """Pictures beside the journal."""
    top = (file for file in inventory.files if "/" not in file.path)
    return [file for file in top if file.format in PICTURES]


def _stale_tables(folder: Path, story: Story) -> list[str]:
    """Tables that do not hold the rows of the journal.

    While a run is unfinished none counts: resume writes them again from the journal. Where
    iterations were done again with something changed, the journal has rows that the table has not.
    """
    if story.finished is None or any(change.reopened for change in story.changes):
        return []
    return [name for name, told in story.tables.items() if not told.fits(folder / name)]


def _is_run_by_another(folder: Path) -> bool:
    """True while an engine holds the run; the one that makes this report at the run's end is none."""
    if not is_live(folder):
        return False
    try:
        return FolderLock(folder).path.read_text().strip() != str(os.getpid())
    except OSError:
        return True
