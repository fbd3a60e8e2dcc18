"""Quick summary of a run that is over: from the file beside its journal, or its journal once."""

from pathlib import Path
from typing import cast

from ...engine.journal.journal import JournalFault
from ...engine.run.folder import ASKED
from ...engine.run.labels import read_object
from ...engine.run.summary import summary_of
from ...schemas.journal import ended_as
from ..models.runs import Fate, RunSummary
from .inputs import read_launch


def quick_summary(folder: Path) -> RunSummary | None:
    """The summary of a run whose last record is `finished`; None for any other.

    None also for a journal without what a summary needs: opening the run tells what is wrong.
    """
    try:
        told = summary_of(folder)
    except (JournalFault, OSError, ValueError):
        return None
    if told.fate in ("running", "interrupted"):
        return None
    points, launch = told.points, read_launch(folder)
    return RunSummary(
        id=folder.name, protocol=told.protocol,
        file=str(read_object(folder / ASKED).get("file", "")),
        fate=cast(Fate, told.fate), word=ended_as(told.fate, told.holes), reason=told.reason, live=False,
        began_at=told.began, ended_at=told.ended,
        done=points.measured + points.failed, measured=points.measured, failed=points.failed,
        left=points.left, total=points.plan,
        holes=told.holes, resumes=told.resumes, operator=launch.operator,
    )  # fmt: skip
