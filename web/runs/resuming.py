"""What would differ if a run were resumed with another protocol, by the engine's comparison."""

import difflib

from ..library.library import Library
from ..local.workers import Worker
from ..models.runs import Changes, ResumeRun
from .launching import text_of
from .runs import Runs

MOST_LINES = 2000
LONGEST_S = 120.0


class Resuming:
    """Compares a run with the protocol in the library."""

    def __init__(self, runs: Runs, library: Library, worker: Worker) -> None:
        self._runs = runs
        self._library = library
        self._worker = worker

    async def changes(self, id: str, asked: ResumeRun) -> Changes:
        """The differences, and whether the run could be resumed; sends and writes nothing."""
        run = await self._runs.opened(id)
        ours = run.inputs.text
        theirs = ours if asked.protocol is None else self._library.read(asked.protocol).text
        if ours == theirs and not asked.params:
            return Changes(same_text=True, diff=[], can_resume=run.fate != "succeeded")
        lines = difflib.unified_diff(
            ours.splitlines(), theirs.splitlines(), run.id, asked.protocol or run.id, lineterm=""
        )
        folder = self._library.folder
        told = {
            "run": str(run.folder), "folder": str(folder),
            "changed": str(folder / asked.protocol) if asked.protocol is not None else None,
            "params": {name: text_of(value) for name, value in asked.params.items()},
        }  # fmt: skip
        found = await self._worker.ask("changes", told, LONGEST_S)
        return Changes(same_text=ours == theirs, diff=list(lines)[:MOST_LINES], **found)
