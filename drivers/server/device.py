"""A device on its server: one driver, its contract, its lease and its goals."""

import asyncio
import contextlib
import logging
import math
import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

from ...schemas.contract import Contract
from ...schemas.messages import DeviceDescription, Goal, GoalState, LeaseRequest, Look
from ...system.tasks import spawn
from ..driver import Driver, Place
from .alone import alone_with
from .arguments import Arguments
from .execution import Ending, Execution, cut_short, fault_of, never_started, not_begun
from .lease import Lease, Refused
from .ledger import Ledger, LedgerFault
from .looking import Looking
from .owner import Owner
from .status import EVERY_S, StatusWatch
from .wire import Tell, wire

STOP_S = 10.0
"""How long a stop waits for the driver to confirm the safe state, unless the lab says."""

ENDS_S = 5.0
"""How long the end of a server waits for goals, once their device is safe or has had its time."""

RECORD_AGAIN_S = 1.0
LOG = logging.getLogger("labrun")


class ServedDevice:
    """Everything about one device that outlives a single goal."""

    def __init__(
        self, place: Place, driver: Driver, contract: Contract, ledger: Ledger, tell: Tell,
        stop_grace_s: float = STOP_S, status_every_s: float | None = EVERY_S,
    ) -> None:  # fmt: skip
        self.name = place.device
        self.stop_grace_s = stop_grace_s
        self._limits = place.limits
        self._driver = driver
        self._having = ExitStack()
        self._contract = contract
        self._cancel_grace_s = contract.cancel_grace_s
        self._ledger = ledger
        self._tell = tell
        self._arguments = {
            name: Arguments(f"{self.name}.{name}", action, place.limits)
            for name, action in contract.actions.items()
        }
        self._status = StatusWatch(driver, self._tell_status, status_every_s)
        self._owner = Owner(self.name, driver, contract, self._status.changed, self._unlease)
        self.running = self._owner.goals
        self.lease = Lease(self.name, ledger, self._owner.lapse)
        self._looking = Looking(self.name, driver, contract, self._in_use)
        self._owning: asyncio.Task[None] | None = None
        self._closed_to_goals: str | None = None
        self._stop = "Stopped", f"{self.name} was stopped"
        """The error of goals that the newest stop meets, and its words."""
        self._unwritten: str | None = None
        self._admitting = asyncio.Lock()

    async def open(self, *, make_safe: bool) -> None:
        """Connect to the hardware; if an earlier server was cut off during an action, make it safe first."""
        if self._driver.alone:
            self._having.enter_context(alone_with(self._driver.alone))
        try:
            await self._driver.open()
        except BaseException:  # a cancel as well
            self._having.close()
            raise
        if make_safe:
            await self._owner.safe()
            self._unlease()
        await self._status.open()
        self._owning = self._owner.open()

    async def abandon(self) -> None:
        """Release what a driver has of an instrument that it could not open: the next one needs it."""
        with contextlib.suppress(Exception):  # it has just failed to open, for whatever reason
            async with asyncio.timeout(self.stop_grace_s):
                await self._driver.close()

    async def wind_down(self) -> None:
        """Accept no more goals, go to the safe state, and end every running goal."""
        self._tell("ending", {"device": self.name}, set())
        self._owner.end()
        self.lease.close()
        safe, _ = await self.stop(name="Lost", by="its server, which ended")
        ends = [execution.task for execution in self.running.values() if execution.task is not None]
        if ends:
            await asyncio.wait(ends, timeout=ENDS_S)
        if safe:
            self._unlease()

    async def close(self) -> None:
        """Release the hardware; nothing is left running."""
        await self._status.close()
        tasks = (self._owning, self._looking.task, *(e.task for e in self.running.values()))
        left = [task for task in tasks if task is not None]
        for task in left:
            task.cancel()
        if left:  # not for ever: what a driver does when it is cancelled is its own matter
            await asyncio.wait(left, timeout=ENDS_S)
        try:
            async with asyncio.timeout(self.stop_grace_s):
                await self._driver.close()
        except Exception:  # the other devices still have to be closed
            LOG.exception("%s could not be closed", self.name)
        self._having.close()

    def describe(self) -> DeviceDescription:
        """What clients need to know to use it."""
        limits = self._limits.items()
        return DeviceDescription(
            contract=self._contract.model_dump(),
            driver=type(self._driver).__name__,
            versions=dict(self._driver.versions),
            limits={name: {"minimum": low, "maximum": high} for name, (low, high) in limits},
            status=self._status.latest,
            holder=self.lease.holder.owner if self.lease.holder is not None else "",
            stopped=self._closed_to_goals or "",
            stop_grace_s=self.stop_grace_s,
        )

    @property
    def calm(self) -> bool:
        """True if it has no lease holder, nothing runs on it and it is not being made safe."""
        return self.lease.holder is None and not self.running and self._owner.at_rest

    async def look(self, above: bool = False) -> Look:
        """What it sees now, for people who look on; raises Refused, also while somebody uses it."""
        return await self._looking.look(above)

    def _in_use(self) -> str:
        if self.lease.holder is not None:
            return f"{self.name} is held by {self.lease.holder.owner}"
        return "" if self.calm else f"{self.name} is busy"

    async def take_lease(self, request: LeaseRequest, session: str) -> int:
        """Grant or renew the lease; taking it deliberately also ends the hold after a stop."""
        before = self.lease.holder.epoch if self.lease.holder is not None else None
        closed = self._closed_to_goals
        epoch = await self.lease.take(request, session)
        if epoch != before and not request.again and self._closed_to_goals is closed:
            self._closed_to_goals = None  # but a stop that came meanwhile holds
        return epoch

    async def release(self, owner: str, epoch: int | None) -> bool:
        """End the lease; if a goal is still running the device is made safe, as on a lapse."""
        over = await self.lease.release(owner, epoch)
        if over is not None and self.running:
            self._owner.lapse(over)
        elif over is not None:
            self._owner.fence(over)
            self._unlease()
        return over is not None

    @property
    def lapsed(self) -> int:
        """The epoch of the newest lease whose end has made it safe; 0 if none has in this boot."""
        return self._owner.lapsed

    @property
    def stops(self) -> int:
        """How often it was stopped: a goal that came before a stop must not start after it."""
        return self._owner.stops

    async def accept(self, goal: Goal, session: str, stops: int) -> Execution:
        """Start a goal that came when `stops` was so much.

        Raises Refused if it must not start, and then nothing has happened.
        """
        action = self._contract.actions.get(goal.action)
        if action is None:
            raise Refused("INVALID", f"{self.name} has no action {goal.action!r}")
        arguments = self._arguments[goal.action]
        async with self._admitting:  # until it is in the ledger, none is checked against what runs
            self._check(goal, arguments)
            if self.stops != stops:
                raise Refused("STOPPED", f"{self._stop[1]}, before the goal began")
            state: GoalState = "EXECUTING" if self._owner.at_rest else "ACCEPTED"
            try:
                seq = await self._ledger.queued(self._ledger.admit, goal, state)
            except LedgerFault as fault:
                raise Refused("REJECTED", f"{fault}; nothing was started") from fault
            execution = Execution(
                goal, action, state, seq, self._ledger.boot, self._tell_progress,
                self._cancel_grace_s,
            )  # fmt: skip
            execution.followers.add(session)
            self.running[goal.id] = execution
        if action.meanwhile and goal.action in self._contract.safe_state:
            words = f"{self.name} was brought to its safe state ({goal.action}) at {_clock()}"
            for other in self.running.values():
                if other is not execution:
                    other.cut_by("Stopped", words)
        if self.stops != stops:
            execution.cut_by(*self._stop)
        execution.task = spawn(f"goal {goal.id}", self._run(execution, arguments))
        return execution

    def _check(self, goal: Goal, arguments: Arguments) -> None:
        self.lease.check(goal.epoch)
        if self._closed_to_goals is not None:
            raise Refused("STOPPED", self._closed_to_goals)
        if self._unwritten is not None:
            raise Refused("REJECTED", self._unwritten)
        wrong = arguments.fault_in(goal)
        if wrong is not None:
            raise Refused("INVALID", wrong)
        meanwhile = self._contract.concurrent or self._contract.actions[goal.action].meanwhile
        if self.running and not meanwhile:
            raise Refused("BUSY", f"{self.name} is busy with {next(iter(self.running))}")

    async def _run(self, execution: Execution, arguments: Arguments) -> None:
        try:
            await self._looking.over()
            ending = await self._perform(execution, arguments)
        except Exception as bug:  # our own: its client must hear of it all the same
            ending = fault_of(arguments.place, bug)
        finally:
            self._owner.returned(execution)
        ending = execution.finish(ending, arguments.place)
        if execution.cut is not None:
            ending = cut_short(ending, execution.cut)
        report = await self._record(execution, ending, arguments.place)
        del self.running[execution.goal.id]
        self._tell("update", report, execution.followers)
        self._status.changed()

    async def _perform(self, execution: Execution, arguments: Arguments) -> Ending:
        while await self._owner.turn(execution):
            if execution.state != "ACCEPTED":
                if (interlock := execution.action.interlock) and not execution.is_cancelled:
                    unmet = await self._status.unmet(interlock)
                    if unmet is not None:
                        return not_begun(f"{arguments.place}: {unmet}")
                if execution.is_cancelled:
                    break
                return await execution.perform(self._driver, arguments)
            self._owner.returned(execution)  # first to disk, and a stop does not wait for disks
            try:
                await self._ledger.queued(self._ledger.begin, execution.goal.id)
            except LedgerFault as fault:
                return not_begun(str(fault))
            if execution.state == "ACCEPTED":
                execution.state = "EXECUTING"
                # A copy of the ledger from before would say that it never began.
                self._tell_progress(execution, mark=self._ledger.mark)
        return never_started(cancelled=execution.is_cancelled)

    async def _record(self, execution: Execution, ending: Ending, place: str) -> dict[str, Any]:
        """Write the outcome to disk, before the report on it is sent; what cannot be written is a Fault.

        Where the disk does not take it, it is reported all the same, and kept until the disk does:
        if this server ends before, its next boot says that the outcome is unknown, and whoever has
        heard it knows more. Until then no goal begins.
        """
        goal_id, boot, given = execution.goal.id, self._ledger.boot, ending
        while True:
            try:
                report = ending.report(goal_id, boot)
                seq = await self._ledger.queued(
                    self._ledger.end, goal_id, ending.state, ending.result, ending.error, ending.files
                )  # fmt: skip
            except Exception as fault:  # no goal may end without an outcome
                if ending is given and not isinstance(fault, LedgerFault):
                    ending = fault_of(place, fault)  # an answer that no disk can hold
                    continue
                if execution.outcome is None:
                    if not isinstance(fault, LedgerFault):
                        LOG.exception("the end of %s cannot be written", goal_id)
                    execution.outcome = ending.report(goal_id, boot, self._ledger.next_seq())
                    self._tell("update", wire(execution.outcome), execution.followers)
                self._unwritten = f"{fault}; nothing begins until the end of {goal_id} is written"
                await asyncio.sleep(RECORD_AGAIN_S)
            else:
                self._unwritten = None
                return {**wire(report), "seq": seq}

    def _tell_progress(self, execution: Execution, **more: str) -> None:
        execution.seq = self._ledger.next_seq()
        self._tell("update", {**wire(execution.report()), **more}, execution.followers)

    def _tell_status(self, status: dict[str, Any]) -> None:
        self._tell("status", {"device": self.name, **status}, set())

    def beat(self) -> None:
        """Send a sign of life for every running goal."""
        for execution in self.running.values():
            if not execution.over:  # its outcome has the next number
                self._tell_progress(execution)

    async def stop(
        self, timeout_s: float = math.inf, *, by: str = "", by_others: bool = False,
        name: str = "Stopped",
    ) -> tuple[bool, str]:  # fmt: skip
        """Go to the safe state now: goals are aborted, the driver is called at once.

        After a stop by others the device takes no more goals until its lease is taken again, since
        its holder does not know about the stop and would send the next goal milliseconds later; the
        same goes for a holder whose lease has lapsed and who is about to come back. Everybody is
        told `by` whom; goals that it meets end with the error `name`.
        """
        by = by or ("another client" if by_others else "the client that uses it")
        words = f"{self.name} was stopped by {by} at {_clock()}"
        if by_others:
            self._closed_to_goals = words
            self._tell("stopped", {"device": self.name, "message": words}, set())
            # If this is not written, a run that is resumed later does not see this stop. The stop
            # does not wait for it, but any later lease does.
            self._note(self._ledger.skip_epoch)
        self._stop = name, words
        answer = self._owner.stop(*self._stop)
        self._status.changed()
        timeout_s = min(timeout_s, self.stop_grace_s)
        done, _ = await asyncio.wait({answer}, timeout=timeout_s)
        if not done:
            return False, f"{self.name} did not confirm its safe state within {timeout_s:g} s"
        return answer.result()

    def _unlease(self) -> None:
        # If this is not written, it only costs one more safe state when the server restarts.
        if self.lease.is_free:
            self._note(self._ledger.unlease)

    def _note(self, write: Callable[[str], None]) -> None:
        """Write in the background, but before everything that is written later."""
        self._ledger.queued(write, self.name).add_done_callback(_heard)


def _clock() -> str:
    return time.strftime("%H:%M:%S")


def _heard(written: asyncio.Future[None]) -> None:
    if not written.cancelled() and (fault := written.exception()) is not None:
        LOG.warning("%s", fault, exc_info=fault)
