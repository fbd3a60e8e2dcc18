"""Rehearsals: checked here, run in the worker, so that nobody else has to wait."""

from pathlib import Path

from ..local.refusal import Refusal
from ..local.workers import Worker, WorkFailed
from ..models.protocols import Rehearsed, RehearseText
from .text_check import TextCheck

LONGEST_S = 300.0


class Rehearsals:
    """Rehearses a text as if it were in `folder`."""

    def __init__(self, worker: Worker, looking: TextCheck, folder: Path, lab: Path | None) -> None:
        self._worker = worker
        self._looking = looking
        self._folder = folder
        self._lab = lab

    async def play(self, asked: RehearseText) -> Rehearsed:
        """The figures; raises Refusal with the text's problems, or why it cannot be rehearsed."""
        await self._looking.for_a_run(asked)
        told = {
            "text": asked.text, "name": str(self._folder / asked.name), "bind": asked.bind,
            "params": asked.params, "fail": asked.fail, "seed": asked.seed,
            "lab": str(self._lab) if self._lab else None,
        }  # fmt: skip
        try:
            return Rehearsed(**await self._worker.ask("rehearse", told, LONGEST_S))
        except WorkFailed as fault:
            raise Refusal(422, "NO_REHEARSAL", f"it cannot be rehearsed: {fault}") from fault
