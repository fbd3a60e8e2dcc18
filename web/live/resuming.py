"""What would be different if a run went on with another protocol: asked of the engine's comparison."""

import asyncio
import difflib
from pathlib import Path

from ...engine.journal import JournalFault, read_records
from ...engine.run_folder import JOURNAL, FolderFault
from ..guard.refusal import Refusal
from ..models.runs import Changes, ResumeRun
from ..shelf.looking import Looking
from ..shelf.shelf import Shelf
from .launching import text_of
from .runs import Runs
from .watched import Watched

MOST_LINES = 2000


class Resuming:
    """Holds a run against the protocol on the shelf."""

    def __init__(self, runs: Runs, shelf: Shelf, looking: Looking) -> None:
        self._runs = runs
        self._shelf = shelf
        self._looking = looking

    async def changes(self, id: str, asked: ResumeRun) -> Changes:
        """What is different, and whether the run could go on so; sends and writes nothing."""
        run = await self._runs.opened(id)
        return await asyncio.to_thread(self._changes, run, asked)

    def _changes(self, run: Watched, asked: ResumeRun) -> Changes:
        theirs = (
            run.inputs.text if asked.protocol is None else self._shelf.read(asked.protocol).text
        )
        diff = list(
            difflib.unified_diff(
                run.inputs.text.splitlines(), theirs.splitlines(), run.id,
                asked.protocol or run.id, lineterm="",
            )
        )[:MOST_LINES]  # fmt: skip
        same = run.inputs.text == theirs
        if same and not asked.params:
            return Changes(same_text=True, diff=[], can_resume=run.fate != "succeeded")
        changed = self._shelf.folder / asked.protocol if asked.protocol is not None else None
        return self._compared(run, asked, changed, diff, same=same)

    def _compared(
        self, run: Watched, asked: ResumeRun, changed: Path | None, diff: list[str], *, same: bool
    ) -> Changes:
        # Here, since they bring the tree along: a fifth of the time in which the server starts.
        from ...engine.commands.changed import newest_copies
        from ...engine.commands.resume import check_copy
        from ...engine.compare import compare

        try:
            records = list(read_records(run.folder / JOURNAL))
            place = newest_copies(run.folder, records)
            params = {name: text_of(value) for name, value in asked.params.items()}
            checked, _ = check_copy(place, changed, params)
        except (JournalFault, FolderFault) as fault:
            raise Refusal(409, "UNREADABLE", str(fault)) from fault
        if not checked.ok:
            problems = self._looking.found(checked)
            raise Refusal(422, "PROBLEMS", "the changed protocol has errors", problems=problems)
        found = compare(checked, run.id, records)
        words = dict.fromkeys(one.words() for one in found.differences if one.was is not None)
        return Changes(
            same_text=same, diff=diff, can_resume=not found.undone, agreeing=found.agreeing,
            different=list(words)[:200], in_the_way=[one.words() for one in found.undone][:200],
            doubtful=[f"{after}: {one.words()}" for one, after in found.doubtful][:200],
            reopened=len(found.reopened),
        )  # fmt: skip
