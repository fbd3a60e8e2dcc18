"""Commands to a live run: pause, continue, abort, answer."""

import asyncio
import logging
from collections.abc import Awaitable
from typing import Any, Literal

from ...engine.control.server import NotLive, Silent
from ...system.tasks import end, spawn
from ..access.headers import Deadline
from ..library.library import Library
from ..local.refusal import Refusal
from ..models.base import Answer
from ..models.devices import StoppedRun
from ..models.runs import AnswerQuestion, ResumeRun
from .endpoint import ask_engine
from .launching import text_of
from .open_run import OpenRun
from .runs import Runs

LOG = logging.getLogger("labrun")
ANSWER_S = 2.0
CHANGE_S = 24 * 3600.0
"""How long a run may take to come to rest."""


class RunCommands:
    """Talks to the engines of live runs."""

    def __init__(self, runs: Runs, library: Library) -> None:
        self._runs = runs
        self._library = library
        self._changing: set[asyncio.Task[tuple[bool, str]]] = set()
        runs.pause_due = self._pause_now

    async def close(self) -> None:
        """Wait for no engine any more; changes that were asked for still come."""
        await end(*self._changing)

    async def pause(self, id: str, when: Literal["now", "after_point"], by: str) -> Answer:
        """Pause once the actions under way end, or when the present iteration ends."""
        run = await self._runs.opened(id)
        current = _current(run)
        if when == "after_point" and current is not None and not run.picture.paused:
            self._check_live(run)
            run.pausing, run.paused_by = current, f"{by}, after the point"
            run.picture.changed.head = True
            return Answer(text=f"the run pauses after the point {current[1]}")
        return await self._ask(run, verb="pause", by=by)

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

    async def change(self, id: str, asked: ResumeRun, by: str, deadline: Deadline) -> Answer:
        """Change the protocol of a live run once it is at rest; answers before that if it takes longer."""
        run = await self._runs.opened(id)
        self._check_live(run)
        file = None
        if asked.protocol is not None:
            self._library.read(asked.protocol)
            file = str(self._library.folder / asked.protocol)
        params = {name: text_of(value) for name, value in asked.params.items()}
        deadline.check()
        work = ask_engine(
            run.folder, CHANGE_S, verb="change", file=file, params=params, yes=asked.yes, by=by
        )
        task = spawn(f"change {id}", work, expected=(NotLive,), among=self._changing)
        done, _ = await asyncio.wait({task}, timeout=ANSWER_S)
        if not done:
            task.add_done_callback(lambda task: self._tell_late(id, task))
            return Answer(text="the run changes when what runs has ended; “Resume” withdraws that")
        return await self._answer(task)

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

    def _tell_late(self, id: str, task: asyncio.Task[tuple[bool, str]]) -> None:
        """What became of a change, to everybody: who asked for it has been answered."""
        if not task.cancelled():
            fault = task.exception()
            ok, text = (False, str(fault)) if fault is not None else task.result()
            told = text if ok else f"{id} was not changed: {text}"
            self._runs.tell(told, id, "info" if ok else "problem")

    async def _pause_now(self, run: OpenRun) -> None:
        try:
            await self._ask(run, verb="pause", by=run.paused_by)
        except Refusal as refusal:
            self._runs.tell(f"{run.id} was not paused: {refusal}", run.id)

    async def _ask(self, run: OpenRun, **request: Any) -> Answer:
        self._check_live(run)
        return await self._answer(ask_engine(run.folder, ANSWER_S, **request))

    async def _answer(self, asking: Awaitable[tuple[bool, str]]) -> Answer:
        try:
            ok, text = await asking
        except Silent as fault:
            raise Refusal(504, "NO_ANSWER", str(fault), "ask again") from fault
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
