"""Commands to a live run: pause, continue, abort, answer."""

import asyncio
import logging
from typing import Any, Literal

from ...engine.control.server import NotLive
from ..access.headers import Deadline
from ..local.refusal import Refusal
from ..models.base import Answer
from ..models.devices import StoppedRun
from ..models.runs import AnswerQuestion
from .endpoint import ask_engine
from .open_run import OpenRun
from .runs import Runs

LOG = logging.getLogger("labrun")
ANSWER_S = 2.0


class RunCommands:
    """Talks to the engines of live runs."""

    def __init__(self, runs: Runs) -> None:
        self._runs = runs
        runs.pause_due = self._pause_now

    async def pause(self, id: str, when: Literal["now", "after_point"]) -> Answer:
        """Pause once the actions under way end, or when the present iteration ends."""
        run = await self._runs.opened(id)
        current = _current(run)
        if when == "after_point" and current is not None and not run.picture.paused:
            self._check_live(run)
            run.pausing = current
            run.picture.changed.head = True
            return Answer(text=f"the run pauses after the point {current[1]}")
        return await self._ask(run, verb="pause", by="the page")

    async def go_on(self, id: str, by: str, deadline: Deadline) -> Answer:
        """Continue after a pause."""
        run = await self._runs.opened(id)
        deadline.check()
        if run.pausing is not None and not run.picture.paused:
            run.pausing = None
            run.picture.changed.head = True
            return Answer(text="the run continues; it does not pause after this point")
        return await self._ask(run, verb="continue", by=by)

    async def abort(self, id: str, by: str, deadline: Deadline) -> Answer:
        """Abort; a second time at once."""
        run = await self._runs.opened(id)
        deadline.check()
        run.pausing = None
        return await self._ask(run, verb="abort", by=by)

    async def answer(
        self, id: str, question: str, asked: AnswerQuestion, by: str, deadline: Deadline
    ) -> Answer:
        """Answer a question that is open."""
        run = await self._runs.opened(id)
        deadline.check()
        return await self._ask(
            run, verb="answer", id=question, choice=asked.choice, values=asked.result, by=by
        )

    async def abort_all(self, timeout_s: float, by: str) -> list[StoppedRun]:
        """Abort every live run: its devices were stopped, so it cannot continue."""

        async def abort(run: OpenRun) -> StoppedRun:
            run.pausing = None
            if run.picture.aborted_by:
                return StoppedRun(run=run.id, told=True, message="it is already being aborted")
            try:
                ok, text = await ask_engine(run.folder, timeout_s, verb="abort", by=by)
            except NotLive as fault:
                return StoppedRun(run=run.id, told=False, message=str(fault))
            except Exception as fault:  # whatever it was: STOP ALL tells of every device and run
                LOG.exception("%s was not aborted", run.id)
                return StoppedRun(run=run.id, told=False, message=f"not aborted: {fault}")
            return StoppedRun(run=run.id, told=ok, message=text)

        return list(await asyncio.gather(*(abort(run) for run in self._runs.live_runs())))

    async def _pause_now(self, run: OpenRun) -> None:
        try:
            await self._ask(run, verb="pause", by="the page, after the point")
        except Refusal as refusal:
            self._runs.tell(f"{run.id} was not paused: {refusal}", run.id)

    async def _ask(self, run: OpenRun, **request: Any) -> Answer:
        self._check_live(run)
        try:
            ok, text = await ask_engine(run.folder, ANSWER_S, **request)
        except NotLive as fault:
            raise Refusal(409, "NOT_LIVE", str(fault), "resume it") from fault
        if not ok:
            raise Refusal(409, "REFUSED", text)
        return Answer(text=text)

    def _check_live(self, run: OpenRun) -> None:
        there = run.live or (run.folder / "control.json").exists()
        if run.picture.finished is not None or not there:
            raise Refusal(
                409, "NOT_LIVE", f"{run.id} is not running", "resume a run that was stopped"
            )


def _current(run: OpenRun) -> tuple[str, str] | None:
    """Loop and key of the outermost iteration that is under way."""
    for table in run.picture.tables.values():
        if table.current is not None and "*" not in table.loop:
            return table.loop, table.keys[table.current]
    return None
