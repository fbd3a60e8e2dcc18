"""One engine's share of a run: the phases from connection to safe state, and resuming from a journal."""

import asyncio
import contextlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime

from py_trees.behaviour import Behaviour

from ...schemas import journal as j
from ...schemas.protocol import Protocol
from ..check import Checked
from ..control.control import Control
from ..dispatch.device_handle import DeviceHandle
from ..dispatch.dispatcher import Dispatcher
from ..journal.encode import with_units
from ..journal.journal import DiskFull, JournalFault, Records
from ..language.expression import ExpressionError
from ..language.moments import moment_text
from ..language.value import value_of
from ..run.files import NoRoom
from ..run.finals import Final
from ..run.frame import Frame, Scope
from ..run.open_uses import OpenUse
from ..run.rows import restore_rows
from ..run.run import Run
from ..tree.compile import TreeCompiler
from ..tree.nodes.failure import Failure
from ..tree.nodes.node import failure_of
from ..tree.tick import StopNow, run_tree
from .finally_limit import limit_s
from .live_change import LiveChange
from .safe_state import (
    mark_state_lost,
    resolve_goals_in_flight,
    to_safe_state,
    touched_since,
)
from .uses_under_way import uses_under_way

LINKS_S = 1.0
"""Within this time every link to a restarted server has reconnected."""


@dataclass(slots=True)
class Ending:
    """How a run ended; `interrupted` when Ctrl-C ended it.

    `reason` is in words; `detail` has the paths and names of errors behind it.
    """

    fate: j.RunFate
    reason: str = ""
    detail: str = ""
    interrupted: bool = False


class RunSession:
    """One engine's share of a run: from its connection to its last record."""

    def __init__(self, run: Run, checked: Checked, clients: Mapping[str, DeviceHandle]) -> None:
        assert checked.lab is not None
        self.run = run
        self.clients = clients
        self.dispatcher = Dispatcher(run, clients, checked.lab.lab.start_timeout_s)
        self.control = Control(run, self.dispatcher.wake.set)
        self.change = LiveChange(run, self.control, clients)
        run.told = self._told
        self.touched: dict[str, str] = {}
        """Devices whose state may have changed before this session -> why."""
        self.unsafe: set[str] = set()
        """Devices that have not confirmed their safe state at the end: their leases have to lapse."""
        self._take(checked)
        self._plant()

    def _take(self, checked: Checked) -> None:
        assert checked.protocol is not None and checked.survey is not None
        self.protocol: Protocol = checked.protocol
        self.survey = checked.survey
        self.names = {
            "params": self.run.params, "run": self.run.about, "csv": self.survey.tables
        }  # fmt: skip

    def _plant(self) -> None:
        """Build a new tree, in which everything done in the run's history counts as done."""
        self.compiler = TreeCompiler(self.run, self.dispatcher, self.survey, self.run.folder)
        self.main_frame = Frame.phase("main", self.names)
        self.run.finals.take()
        self.run.strands.clear()
        self.main = self.compiler.sequence(self.protocol.steps, Scope(self.main_frame))

    def _told(self, role: str) -> object:
        bound = self.run.roles[role]
        return with_units(self.dispatcher.status(bound.device)[0], bound.contract.status)

    async def execute(self, records: Iterable[j.JournalRecord] | None) -> Ending:
        """Everything from the first phase to the safe state; never leaves a goal under way."""
        if records is not None:
            restore_rows(self.run.folder, records, self.compiler.tables)
        ending = Ending("failed")
        self.touched = touched_since(self.run, self.clients)
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
            for told in filter(None, (table.finish() for table in self.compiler.tables.values())):
                self.run.log(told)
        ending.interrupted = self.control.aborted_by == "Ctrl-C"
        return ending

    async def _phases(self, *, resumed: bool) -> Ending:
        if resumed:
            history = self.run.history
            await resolve_goals_in_flight(self.run, self.dispatcher, self.control)
            if doubtful := sorted(self.run.history.doubtful):
                self.run.log(
                    "this run's folder was put back from an older copy, and what was done since is in no "
                    f"ledger of {', '.join(doubtful)}: before each action that must not happen twice, "
                    "it is asked whether it happened"
                )
            for device, reason in self.touched.items():
                mark_state_lost(self.run, device, reason)
            if not history.cleaned_up:  # the engine was killed
                await self._finally()
                await self._make_safe()
            on_resume = await self._on_resume(history.resumes)
            if on_resume is not None:
                return await self._then_finally(on_resume)
        while True:
            self.run.past = self.run.history.past.copy()
            self._begin("main")
            with self.change.possible():
                ended = await run_tree(
                    self.main, self.run, self.dispatcher, self.control, abortable=True,
                    watchful=True,
                )  # fmt: skip
                if ended == "changed":
                    await self.change.make(self._plant_changed)
                    continue
            if ended != "state lost":
                return await self._then_finally(self._ending(ended, "main"))
            on_resume = await self._take_up_again()
            if on_resume is not None:
                return await self._then_finally(on_resume)

    async def _take_up_again(self) -> Ending | None:
        """A device lost its state under a running engine: continue as after a crash, from the journal.

        Without `finally`, since the engine was never gone: `on_resume`, then the unfinished iterations, in
        which the finished steps of that device are repeated before anything else is done once.
        """
        lost = await self._see_what_is_lost()
        self.dispatcher.look_anew()
        self._plant_anew()
        await resolve_goals_in_flight(self.run, self.dispatcher, self.control)
        return await self._on_resume(self.run.history.resumes + 1) if lost else None

    def _plant_anew(self) -> None:
        self._plant()
        records = Records(self.run.journal.path)
        restore_rows(self.run.folder, records, self.compiler.tables)

    def _plant_changed(self, checked: Checked) -> None:
        self._take(checked)
        self._plant_anew()

    async def _see_what_is_lost(self) -> bool:
        """Mark the devices that were stopped, or have lost their state; false if there are none."""
        stopped = dict(self.dispatcher.stopped)
        if self.dispatcher.states_lost().keys() - stopped.keys():
            # The links of several devices on one server notice its restart at slightly different times.
            await asyncio.sleep(LINKS_S)
        lost = self.dispatcher.states_lost() | stopped
        for device, reason in lost.items():
            mark_state_lost(self.run, device, reason)
            who = reason if device in stopped else f"{device}: {reason}"
            self.run.log(f"{who}; continuing from the journal")
        if self.run.requests.take_up:
            self.run.record(j.Again())
            self.run.requests.take_up = False
        self.run.journal.flush()
        return bool(lost)

    async def _on_resume(self, number: int) -> Ending | None:
        """Run every `on_resume` that is due, from the beginning again after a stop.

        After the protocol's own come those of the used protocols in which the run was, the outermost
        first. Returns an ending if one did not succeed.
        """
        uses = await uses_under_way(self.run, self.protocol, self.survey, self._told)
        while self.protocol.on_resume or uses:
            phase = f"resume:{number}"
            self._begin(phase)
            for root in self._resumptions(phase, uses):
                ended = await run_tree(
                    root, self.run, self.dispatcher, self.control, abortable=True, watchful=True
                )
                if ended == "state lost":
                    break
                if ended != "succeeded":
                    return self._ending(ended, phase, failure_of(root))
            else:
                return None
            await self._see_what_is_lost()
            self.dispatcher.look_anew()
            number = self.run.history.resumes + 1
        return None

    def _resumptions(self, phase: str, uses: Iterable[OpenUse]) -> Iterator[Behaviour]:
        if self.protocol.on_resume:
            scope = Scope(Frame.phase(phase, self.names))
            yield self.compiler.sequence(self.protocol.on_resume, scope)
        for use in uses:
            scope = Scope(Frame.phase(f"{phase}/{use.path}", use.names))
            yield use.build(self.compiler, scope)

    def _ending(self, ended: str, phase: str, failure: Failure | None = None) -> Ending:
        if ended == "aborted":
            return Ending("aborted", f"aborted by {self.control.aborted_by}")
        if ended == "failed":
            failure = failure or failure_of(self.main)
            said = (failure.words(), failure.sentence())
            reason, detail = said if phase == "main" else (f"{phase}: {text}" for text in said)
            return Ending("aborted" if failure.stop else "failed", reason, detail)
        return Ending("succeeded")

    async def _then_finally(self, ending: Ending) -> Ending:
        failure = await self._finally()
        if failure is not None:
            words, detail = (f"finally: {text}" for text in failure)
            ending.detail = f"{ending.detail}; {detail}" if ending.detail else detail
            ending.reason = f"{ending.reason}; {words}" if ending.reason else words
            ending.fate = "failed" if ending.fate == "succeeded" else ending.fate
        elif self.run.left_undone and ending.fate == "succeeded":
            ending.reason = f"finally: {'; '.join(self.run.left_undone.values())}"
        return ending

    async def _finally(self) -> tuple[str, str] | None:
        """Run every `finally` that is due, never cut short by the abort that caused it.

        Those of used protocols that were stopped come first, starting with the innermost. Returns
        words and details if one failed; the others still run.
        """
        if not self.protocol.finally_ and not self.run.finals:
            return None
        phase = f"finally:{self.run.history.finals + 1}"
        self._begin(phase)
        failures: list[Failure] = []
        finals = self.run.finals.take()
        every = [(one.steps, one.names) for _, one in finals]
        at_most_s = limit_s([*every, (self.protocol.finally_, self.main_frame.names)])
        try:
            async with asyncio.timeout(at_most_s):
                for root in self._finals(phase, finals):
                    ended = await run_tree(
                        root, self.run, self.dispatcher, self.control, abortable=False
                    )
                    if ended != "succeeded":
                        failures.append(failure_of(root))
        except TimeoutError:
            late = (
                f"not finished within {at_most_s:g} s; a step that takes long states its `timeout`"
            )
            return late, late
        if not failures:
            return None
        return "; ".join(f.words() for f in failures), "; ".join(f.sentence() for f in failures)

    def _finals(self, phase: str, due: Iterable[tuple[str, Final]]) -> Iterator[Behaviour]:
        for path, final in due:
            yield final.build(Scope(Frame.phase(f"{phase}/{path}", final.names, final.frame)))
        if self.protocol.finally_:
            frame = Frame.phase(phase, self.names, self.main_frame)
            yield self.compiler.finals(self.protocol.finally_, Scope(frame))

    def _begin(self, phase: str) -> None:
        if phase == "main" and not self.run.history.main_at:
            self.run.clock.begin()
        self.run.record(j.Phase(phase=phase))
        self.run.tell("phase", phase)

    async def _out_of_room(self, reason: str) -> Ending:
        """The disk is full: end what runs, try `finally` in the space reserved for it."""
        self.run.log(reason)
        ending = Ending("failed", reason)
        with contextlib.suppress(StopNow, NoRoom, DiskFull, JournalFault):
            await self.dispatcher.drain(60.0, stop=lambda: self.control.now)
            self.dispatcher.disk_full = ""
            ending = await self._then_finally(ending)
        return ending

    async def _make_safe(self) -> None:
        self.unsafe = await to_safe_state(self.run, self.dispatcher, self.clients)

    def outputs(self) -> dict[str, object]:
        """The protocol's outputs; one that cannot be computed is null."""
        told: dict[str, object] = {}
        for name, raw in self.protocol.outputs.items():
            try:
                names = self.run.names(self.main_frame.names, f"outputs/{name}")
                found = value_of(raw).evaluate(names)
                told[name] = moment_text(found) if isinstance(found, datetime) else found
            except ExpressionError as fault:
                told[name] = None
                self.run.log(f"output {name!r}: {fault}")
        return told
