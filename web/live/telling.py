"""Tell a live run something: pause, continue, abort, an answer."""

import asyncio
from typing import Literal

from ...engine.control_server import NotLive
from ..guard.headers import Deadline
from ..guard.refusal import Refusal
from ..models.devices import StoppedRun
from ..models.told import Said
from .endpoint import ask_engine
from .runs import Runs
from .watched import Watched

ANSWER_S = 2.0


class Telling:
    """Speaks to the engines of live runs."""

    def __init__(self, runs: Runs) -> None:
        self._runs = runs
        runs.pause_due = self._pause_now

    async def pause(self, id: str, when: Literal["now", "after_point"]) -> Said:
        """Pause when what runs is finished, or when the present iteration is over."""
        run = await self._runs.opened(id)
        current = _current(run)
        if when == "after_point" and current is not None and not run.picture.paused:
            self._check_live(run)
            run.pausing = current
            run.picture.changed.head = True
            return Said(text=f"the run pauses when the point {current[1]} is over")
        return await self._ask(run, verb="pause", by="the page")

    async def go_on(self, id: str, by: str, deadline: Deadline) -> Said:
        """Go on after a pause."""
        run = await self._runs.opened(id)
        deadline.check()
        if run.pausing is not None and not run.picture.paused:
            run.pausing = None
            run.picture.changed.head = True
            return Said(text="the run goes on; it does not pause after this point")
        return await self._ask(run, verb="continue", by=by)

    async def abort(self, id: str, by: str, deadline: Deadline) -> Said:
        """Abort; a second time at once."""
        run = await self._runs.opened(id)
        deadline.check()
        run.pausing = None
        return await self._ask(run, verb="abort", by=by)

    async def answer(
        self, id: str, question: str, choice: str, by: str, deadline: Deadline
    ) -> Said:
        """Answer a question that is open."""
        run = await self._runs.opened(id)
        deadline.check()
        return await self._ask(run, verb="answer", id=question, choice=choice, by=by)

    async def abort_all(self, timeout_s: float) -> list[StoppedRun]:
        """Abort every live run: what was stopped under its hands cannot go on."""

        async def abort(run: Watched) -> StoppedRun:
            run.pausing = None
            if run.picture.aborting:
                return StoppedRun(run=run.id, told=True, message="it is being aborted already")
            try:
                ok, text = await ask_engine(run.folder, timeout_s, verb="abort", by="STOP ALL")
            except NotLive as fault:
                return StoppedRun(run=run.id, told=False, message=str(fault))
            return StoppedRun(run=run.id, told=ok, message=text)

        return list(await asyncio.gather(*(abort(run) for run in self._runs.live())))

    async def _pause_now(self, run: Watched) -> None:
        try:
            await self._ask(run, verb="pause", by="the page, after the point")
        except Refusal as refusal:
            self._runs.tell(f"{run.id} was not paused: {refusal}", run.id)

    async def _ask(self, run: Watched, **request: str) -> Said:
        self._check_live(run)
        try:
            ok, text = await ask_engine(run.folder, ANSWER_S, **request)
        except NotLive as fault:
            raise Refusal(409, "NOT_LIVE", str(fault), "resume it") from fault
        if not ok:
            raise Refusal(409, "REFUSED", text)
        return Said(text=text)

    def _check_live(self, run: Watched) -> None:
        there = run.live or (run.folder / "control.json").exists()
        if run.picture.finished is not None or not there:
            raise Refusal(
                409, "NOT_LIVE", f"{run.id} is not running", "a run that was stopped is resumed"
            )


def _current(run: Watched) -> tuple[str, str] | None:
    """Loop and key of the outermost iteration that is under way."""
    for table in run.picture.tables.values():
        if table.current is not None and "*" not in table.loop:
            return table.loop, table.keys[table.current]
    return None
