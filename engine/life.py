"""One engine's share of a run: the phases from connection to safe state, and going on from a journal."""

import asyncio
import contextlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime

from py_trees.behaviour import Behaviour

from ..schemas import journal as j
from ..schemas.protocol import Protocol
from .check import Checked
from .compile import TreeCompiler
from .control import Control
from .dispatcher import Dispatcher
from .failure import Failure
from .frame import Frame, Scope
from .history import History, read_history
from .journal import DiskFull, JournalFault, read_records
from .language.expression import ExpressionError
from .language.value import value_of
from .nodes.node import failure_of
from .reached import Reached
from .rows import restore_rows
from .run import Run
from .safe import note_touched, settle, strangers, to_safe_state, touched
from .tick import NoRoom, StopNow, run_tree

LINKS_S = 1.0
"""Within that time every link to a server that was started anew has found it again."""
FINALLY_S = 600.0
"""The time that `finally` has in all."""


@dataclass(slots=True)
class Ending:
    """How a run ended; `interrupted` when Ctrl-C ended it."""

    fate: j.RunFate
    reason: str = ""
    interrupted: bool = False


class Life:
    """One engine's share of a run: from its connection to its last record."""

    def __init__(self, run: Run, checked: Checked, clients: Mapping[str, Reached]) -> None:
        assert checked.protocol is not None and checked.survey is not None
        self.run = run
        self.protocol: Protocol = checked.protocol
        self.survey = checked.survey
        self.names = {"params": run.params, "run": run.about, "csv": self.survey.tables}
        self.clients = clients
        self.dispatcher = Dispatcher(run, clients)
        self.control = Control(run, self.dispatcher.wake.set)
        self.by_strangers: set[str] = set()
        self._plant()

    def _plant(self) -> None:
        """A fresh tree: what the run's history says is done, it takes as done."""
        self.compiler = TreeCompiler(self.run, self.dispatcher, self.survey, self.run.folder)
        self.main_frame = Frame.phase("main", self.names)
        self.run.cut_off.clear()
        self.main = self.compiler.sequence(self.protocol.steps, Scope(self.main_frame))

    async def live(self, records: list[j.JournalRecord] | None) -> Ending:
        """Everything from the first phase to the safe state; never leaves a goal under way."""
        if records is not None:
            restore_rows(self.run.folder, records, self.compiler.tables)
        ending = Ending("failed")
        self.by_strangers = strangers(self.run, self.clients)
        self.dispatcher.look_anew()
        try:
            ending = await self._phases(resumed=records is not None)
        except StopNow:
            ending = Ending("aborted", f"stopped at once by {self.control.aborted_by}")
        except (NoRoom, DiskFull, JournalFault) as fault:
            ending = await self._out_of_room(str(fault))
        finally:
            await self._make_safe()
            await self.dispatcher.close()
        ending.interrupted = self.control.aborted_by == "Ctrl-C"
        return ending

    async def _phases(self, *, resumed: bool) -> Ending:
        if resumed:
            history = self.run.history
            await settle(self.run, self.dispatcher, self.control)
            note_touched(self.run, self.clients, _away_s(history), self.by_strangers)
            if history.finished is None:  # the engine was killed: nobody has cleaned up
                await self._finally()
                await self._make_safe()
            on_resume = await self._on_resume()
            if on_resume is not None:
                return await self._then_finally(on_resume)
        while True:
            self._begin("main")
            ended = await run_tree(
                self.main, self.run, self.dispatcher, self.control, abortable=True, watchful=True
            )
            if ended != "touched":
                return await self._then_finally(self._ending(ended, "main"))
            on_resume = await self._take_up_again()
            if on_resume is not None:
                return await self._then_finally(on_resume)

    async def _take_up_again(self) -> Ending | None:
        """A device lost its state under a living engine: go on as after a crash, from the journal.

        Without `finally`, since nobody was away: `on_resume`, then the unfinished iterations, in
        which the finished steps of that device are repeated before anything else is done once.
        """
        if self.dispatcher.touched():
            # A server with several devices is seen anew by each one's link, a moment apart.
            await asyncio.sleep(LINKS_S)
        lost = self.dispatcher.touched()
        for device, reason in lost.items():
            touched(self.run, device, reason)
            self.run.log(f"{device}: {reason}; going on from the journal")
        if self.run.taken_up:
            self.run.record(j.Again())
            self.run.taken_up = False
        self.run.journal.flush()
        records = list(read_records(self.run.journal.path))
        self.run.history = read_history(records)
        self.run.history.resumes += bool(lost)
        self.run.holes = self.run.history.holes
        self.run.repeated.clear()
        self.dispatcher.look_anew()
        self._plant()
        restore_rows(self.run.folder, records, self.compiler.tables)
        await settle(self.run, self.dispatcher, self.control)
        return await self._on_resume() if lost else None

    async def _on_resume(self) -> Ending | None:
        """Run `on_resume`; an ending where it did not succeed."""
        steps = self.protocol.on_resume
        if not steps:
            return None
        phase = f"resume:{self.run.history.resumes}"
        self._begin(phase)
        root = self.compiler.sequence(steps, Scope(Frame.phase(phase, self.names)))
        ended = await run_tree(root, self.run, self.dispatcher, self.control, abortable=True)
        if ended == "succeeded":
            return None
        return self._ending(ended, phase, failure_of(root))

    def _ending(self, ended: str, phase: str, failure: Failure | None = None) -> Ending:
        if ended == "aborted":
            return Ending("aborted", f"aborted by {self.control.aborted_by}")
        if ended == "failed":
            failure = failure or failure_of(self.main)
            reason = failure.sentence() if phase == "main" else f"{phase}: {failure.sentence()}"
            return Ending("aborted" if failure.stop else "failed", reason)
        return Ending("succeeded")

    async def _then_finally(self, ending: Ending) -> Ending:
        failure = await self._finally()
        if failure is not None:
            reason = f"finally: {failure}"
            ending.reason = f"{ending.reason}; {reason}" if ending.reason else reason
            ending.fate = "failed" if ending.fate == "succeeded" else ending.fate
        return ending

    async def _finally(self) -> str | None:
        """Run every `finally` that is due, never cut short by the abort that caused it.

        Those of used protocols that were stopped come first, the innermost before all. Returns a
        sentence if one failed; the others run all the same.
        """
        if not self.protocol.finally_ and not self.run.cut_off:
            return None
        self.run.history.finals += 1
        phase = f"finally:{self.run.history.finals}"
        self._begin(phase)
        failures: list[str] = []
        try:
            async with asyncio.timeout(FINALLY_S):
                for root in self._finals(phase):
                    ended = await run_tree(
                        root, self.run, self.dispatcher, self.control, abortable=False
                    )
                    if ended != "succeeded":
                        failures.append(failure_of(root).sentence())
        except TimeoutError:
            return f"not over within {FINALLY_S:g} s"
        return "; ".join(failures) or None

    def _finals(self, phase: str) -> Iterator[Behaviour]:
        cut_off, self.run.cut_off = self.run.cut_off, {}
        for path, left in reversed(cut_off.items()):
            yield left.build(Scope(Frame.phase(f"{phase}/{path}", left.names, left.frame)))
        if self.protocol.finally_:
            frame = Frame.phase(phase, self.names, self.main_frame)
            yield self.compiler.sequence(self.protocol.finally_, Scope(frame))

    def _begin(self, phase: str) -> None:
        self.run.history.phase = phase
        self.run.record(j.Phase(phase=phase))
        self.run.tell("phase", phase)

    async def _out_of_room(self, reason: str) -> Ending:
        """The disk is full: end what runs, try `finally` in the room that was kept for it."""
        self.run.log(reason)
        ending = Ending("failed", reason)
        with contextlib.suppress(StopNow, NoRoom, DiskFull, JournalFault):
            await self.dispatcher.drain(60.0, stop=lambda: self.control.now)
            self.dispatcher.disk_full = ""
            ending = await self._then_finally(ending)
        return ending

    async def _make_safe(self) -> None:
        await to_safe_state(self.run, self.dispatcher, self.clients)

    def outputs(self) -> dict[str, object]:
        """The protocol's outputs; one that cannot be told is null."""
        told: dict[str, object] = {}
        for name, raw in self.protocol.outputs.items():
            try:
                told[name] = value_of(raw).evaluate(self.main_frame.names)
            except ExpressionError as fault:
                told[name] = None
                self.run.log(f"output {name!r}: {fault}")
        return told


def _away_s(history: History) -> float:
    """How long no engine has written to the journal."""
    return (datetime.now(UTC) - datetime.fromisoformat(history.last_at)).total_seconds()
