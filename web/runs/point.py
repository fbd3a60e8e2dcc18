"""One iteration, read again from its part of the journal."""

import asyncio
from pathlib import Path
from typing import Any

from ...engine.journal.course import split_goal_id
from ...engine.journal.journal import read_between
from ...engine.run.folder import JOURNAL
from ...schemas import journal as j
from ..local.refusal import not_found
from ..models.runs import ActionTold, LogLine, PointDetail
from ..report.formatting import seconds_between
from .log import is_line, line_of, path_of
from .open_run import OpenRun
from .outline import Found, Outline

SPECTRA = (".csv", ".tsv", ".txt")


async def point_detail(run: OpenRun, loop: str, within: str, key: str) -> PointDetail:
    """Its actions with all attempts, its row, its log; raises Refusal (404)."""
    picture = run.picture
    table = picture.tables.get((loop, within))
    if table is None or key not in table.slots:
        raise not_found("point", key, "it has not begun, or the run has no such loop")
    slot = table.slots[key]
    items = picture.items(loop)
    x_mm, y_mm = items.place(table.index[slot]) if items else (None, None)
    reader = _Reader(run.inputs.outline, loop, within, key)
    first, last = table.first[slot], table.last[slot]
    await asyncio.to_thread(reader.read, run.folder / JOURNAL, first, last)
    actions = list(reader.actions.values())
    files = [file for action in actions for file in action.files]
    return PointDetail(
        point=table.point(slot), x_mm=x_mm, y_mm=y_mm, row=reader.row, actions=actions,
        log=reader.log, spectra=[file for file in files if file.lower().endswith(SPECTRA)],
    )  # fmt: skip


class _Reader:
    """Picks the records of one iteration; runs in a thread, without the run's picture."""

    def __init__(self, outline: Outline | None, loop: str, within: str, key: str) -> None:
        self.actions: dict[str, ActionTold] = {}
        self.log: list[LogLine] = []
        self.row: dict[str, Any] | None = None
        self._outline = outline
        self._place = (loop, within, key)
        self._sent: dict[str, j.GoalSent] = {}

    def read(self, journal: Path, first: int, last: int) -> None:
        for record in read_between(journal, first, last):
            self._take(record)

    def _take(self, record: j.JournalRecord) -> None:
        path = path_of(record)
        found = self._outline.find(path) if self._outline is not None and path else None
        if found is None:
            return
        if isinstance(record, j.IterationEnded):
            if (found.step.told.path, found.within, record.key) == self._place:
                self.row = record.row or self.row
            return
        if not self._is_ours(found):
            return
        sent = None
        if isinstance(record, j.GoalSent):
            self._sent[record.id] = record
            self.actions[record.id] = _begun(record, found)
        elif isinstance(record, j.GoalEnded) and record.id in self.actions:
            sent = self._sent[record.id]
            self.actions[record.id] = _over(self.actions[record.id], record)
        if is_line(record):
            self.log.append(line_of(record, sent, self._outline))

    def _is_ours(self, found: Found) -> bool:
        within = ""
        for loop, key in found.loops:
            if (loop, within, key) == self._place:
                return True
            within = f"{within}/{key}" if within else key
        return False


def _begun(record: j.GoalSent, found: Found) -> ActionTold:
    return ActionTold.of(
        record, node=found.step.told.path, line=found.step.told.line,
        attempt=split_goal_id(record.id)[1], state="EXECUTING", result=None, error=None,
        sent_at=record.at, ended_at=None, seconds=None, files=[],
    )  # fmt: skip


def _over(action: ActionTold, record: j.GoalEnded) -> ActionTold:
    took = seconds_between(action.sent_at, record.at)
    error = record.error.model_dump(exclude_none=True) if record.error is not None else None
    return action.model_copy(
        update={
            "state": record.state,
            "result": record.result,
            "error": error,
            "ended_at": record.at,
            "seconds": round(took, 3),
            "files": list(record.files),
        }
    )
