"""What would be different if a run went on with another protocol: asked of the engine's comparison."""

import difflib

from ..models.runs import Changes, ResumeRun
from ..shelf.shelf import Shelf
from ..workers import Worker
from .launching import text_of
from .runs import Runs

MOST_LINES = 2000
LONGEST_S = 120.0


class Resuming:
    """Holds a run against the protocol on the shelf."""

    def __init__(self, runs: Runs, shelf: Shelf, worker: Worker) -> None:
        self._runs = runs
        self._shelf = shelf
        self._worker = worker

    async def changes(self, id: str, asked: ResumeRun) -> Changes:
        """What is different, and whether the run could go on so; sends and writes nothing."""
        run = await self._runs.opened(id)
        ours = run.inputs.text
        theirs = ours if asked.protocol is None else self._shelf.read(asked.protocol).text
        if ours == theirs and not asked.params:
            return Changes(same_text=True, diff=[], can_resume=run.fate != "succeeded")
        lines = difflib.unified_diff(
            ours.splitlines(), theirs.splitlines(), run.id, asked.protocol or run.id, lineterm=""
        )
        folder = self._shelf.folder
        told = {
            "run": str(run.folder), "folder": str(folder),
            "changed": str(folder / asked.protocol) if asked.protocol is not None else None,
            "params": {name: text_of(value) for name, value in asked.params.items()},
        }  # fmt: skip
        found = await self._worker.ask("changes", told, LONGEST_S)
        return Changes(same_text=ours == theirs, diff=list(lines)[:MOST_LINES], **found)
