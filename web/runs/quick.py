"""Summaries of runs that are not open, from the entries that the engine's index has of them."""

from pathlib import Path
from typing import cast

from ...engine.index.entry import Entry, entry_of
from ..models.runs import Fate, RunSummary


def quick_summary(folder: Path) -> RunSummary | None:
    """The summary of a run whose last record is `finished`; None for any other.

    None also for a journal without what a summary needs: opening the run tells what is wrong.
    """
    entry = entry_of(folder)
    return None if entry.fate in ("running", "interrupted", "unreadable") else summary_from(entry)


def summary_from(entry: Entry) -> RunSummary:
    """As in the list of runs."""
    points = entry.points
    return RunSummary(
        id=entry.run, protocol=entry.protocol, file=entry.file, fate=cast(Fate, entry.fate),
        word=entry.word, reason=entry.reason, live=False,
        began_at=entry.began, ended_at=entry.ended or None,
        done=points.measured + points.failed, measured=points.measured, failed=points.failed,
        left=points.left, total=points.plan, holes=entry.holes, resumes=entry.resumes,
        operator=entry.person,
    )  # fmt: skip
