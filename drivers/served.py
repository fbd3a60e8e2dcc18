"""A device as its server keeps it: one driver, its contract, its lease and its goals."""

import asyncio
import contextlib
import logging
import time
from collections.abc import Coroutine
from typing import Any

from ..schemas.contract import Contract
from ..schemas.messages import DeviceDescription, Goal, GoalReport, GoalState, LeaseRequest
from .arguments import Arguments
from .driver import Driver, Place
from .execution import Ending, Execution, never_started, not_begun
from .lease import Lease, Refused
from .ledger import Ledger, LedgerFault
from .safety import Safety
from .status import StatusWatch
from .wire import Tell, wire

STOP_S = 10.0
"""How long a stop waits for the driver to confirm the safe state."""

FINISH_S = 600.0
"""How long a device whose lease has lapsed may finish what it does."""

WIND_DOWN_S = 5.0
RECORD_AGAIN_S = 1.0
LOG = logging.getLogger(__name__)


class ServedDevice:
    """Everything about one device that outlives a single goal."""

    def __init__(
        self, place: Place, driver: Driver, contract: Contract, ledger: Ledger, tell: Tell
    ) -> None:
        self.name = place.device
        self.running: dict[str, Execution] = {}
        self.lease = Lease(self.name, ledger, self._lapsed)
        self._limits = place.limits
        self._driver = driver
        self._contract = contract
        self._ledger = ledger
        self._tell = tell
        self._arguments = {
            name: Arguments(f"{self.name}.{name}", action, place.limits)
            for name, action in contract.actions.items()
        }
        self._status = StatusWatch(driver, self._tell_status)
        self._safety = Safety(self.name, driver, contract, self._status.changed)
        self._closed_to_goals: str | None = None
        self._ending = False
        self._tasks: set[asyncio.Task[None]] = set()

    async def open(self, *, make_safe: bool) -> None:
        """Reach the hardware; where an earlier server was cut off in mid-action, calm it first."""
        await self._driver.open()
        if make_safe:
            await self._safety.begin()
            self._unlease()
        await self._status.open()

    async def wind_down(self, timeout_s: float = WIND_DOWN_S) -> None:
        """No more goals, safe state, and every goal that runs brought to its end."""
        self._ending = True
        self.lease.close()
        safe, _ = await self.stop(timeout_s)
        await self._until_idle(timeout_s)
        if safe:
            self._unlease()

    async def close(self, timeout_s: float = WIND_DOWN_S) -> None:
        """Let go of the hardware; nothing is left to run."""
        await self._status.close()
        await self._safety.close(timeout_s)
        left = set(self._tasks)
        for task in left:
            task.cancel()
        if left:
            await asyncio.wait(left, timeout=timeout_s)
        try:
            async with asyncio.timeout(timeout_s):
                await self._driver.close()
        except Exception as fault:  # the other devices still have to be closed
            LOG.warning("%s could not be closed: %s: %s", self.name, type(fault).__name__, fault)

    def describe(self) -> DeviceDescription:
        """What others need to know to use it."""
        limits = self._limits.items()
        return DeviceDescription(
            contract=self._contract.model_dump(),
            driver=type(self._driver).__name__,
            versions=dict(self._driver.versions),
            limits={name: {"minimum": low, "maximum": high} for name, (low, high) in limits},
            status=self._status.latest,
        )

    @property
    def calm(self) -> bool:
        """True when nobody answers for it, nothing runs on it and it is not being made safe."""
        return self.lease.holder is None and not self.running and self._safety.under_way is None

    def take_lease(self, request: LeaseRequest, session: str) -> int:
        """Give or prolong the lease; taking it deliberately also ends the hold after a stop."""
        if self._ending:
            raise Refused("REJECTED", f"the device server of {self.name} is ending")
        before = self.lease.holder.epoch if self.lease.holder is not None else None
        epoch = self.lease.take(request, session)
        if epoch != before and not request.again:
            self._closed_to_goals = None
        return epoch

    def release(self, owner: str, epoch: int | None) -> bool:
        """End the lease; with a goal still under way the device is made safe, as on a lapse."""
        released = self.lease.release(owner, epoch)
        if released and self.running:
            self._lapsed()
        elif released:
            self._unlease()
        return released

    def accept(self, goal: Goal, session: str) -> Execution:
        """Start a goal; raises Refused where that must not be, and then nothing has happened."""
        action = self._contract.actions.get(goal.action)
        if action is None:
            raise Refused("INVALID", f"{self.name} has no action {goal.action!r}")
        arguments = self._arguments[goal.action]
        self._check(goal, arguments)
        state: GoalState = "EXECUTING" if self._safety.under_way is None else "ACCEPTED"
        try:
            seq = self._ledger.admit(goal, state)
        except LedgerFault as fault:
            raise Refused("REJECTED", f"{fault}; nothing was started") from fault
        execution = Execution(goal, action, state, seq, self._ledger.boot, self._tell_progress)
        execution.followers.add(session)
        self.running[goal.id] = execution
        execution.task = self._start(self._run(execution, arguments))
        return execution

    def _check(self, goal: Goal, arguments: Arguments) -> None:
        self.lease.check(goal.epoch)
        if self._closed_to_goals is not None:
            raise Refused("REJECTED", self._closed_to_goals)
        wrong = arguments.fault_in(goal)
        if wrong is not None:
            raise Refused("INVALID", wrong)
        meanwhile = self._contract.concurrent or self._contract.actions[goal.action].meanwhile
        if self.running and not meanwhile:
            raise Refused("BUSY", f"{self.name} is busy with {next(iter(self.running))}")

    async def _run(self, execution: Execution, arguments: Arguments) -> None:
        ending = await self._perform(execution, arguments)
        report = await self._record(execution, ending)
        del self.running[execution.goal.id]
        self._tell("update", wire(report), execution.followers)
        self._status.changed()

    async def _perform(self, execution: Execution, arguments: Arguments) -> Ending:
        while self._safety.under_way is not None and execution.state == "ACCEPTED":
            if not await execution.wait_for(self._safety.under_way):
                return never_started()
        if execution.context.cancelled.is_set():
            return never_started()
        if execution.state == "ACCEPTED":
            try:
                execution.seq = self._ledger.begin(execution.goal.id)
            except LedgerFault as fault:
                return not_begun(str(fault))
            execution.state = "EXECUTING"
            self._tell_progress(execution)
        return await execution.perform(self._driver, arguments)

    async def _record(self, execution: Execution, ending: Ending) -> GoalReport:
        """The outcome on disk; while the disk takes nothing the goal has not ended."""
        goal_id, state, result, error = execution.goal.id, ending.state, ending.result, ending.error
        while True:
            try:
                seq = self._ledger.end(goal_id, state, result, error, ending.files)
            except LedgerFault as fault:
                execution.message = f"waiting to record the outcome: {fault}"
                self._tell_progress(execution)
                await asyncio.sleep(RECORD_AGAIN_S)
            else:
                return GoalReport(
                    id=goal_id, state=state, seq=seq, boot=self._ledger.boot,
                    result=result, error=error, files=ending.files,
                )  # fmt: skip

    def _tell_progress(self, execution: Execution) -> None:
        execution.seq = self._ledger.next_seq()
        self._tell("update", wire(execution.report()), execution.followers)

    def _tell_status(self, status: dict[str, Any]) -> None:
        self._tell("status", {"device": self.name, **status}, set())

    def beat(self) -> None:
        """A sign of life of every goal that runs."""
        for execution in self.running.values():
            self._tell_progress(execution)

    async def stop(self, timeout_s: float = STOP_S, *, by_others: bool = False) -> tuple[bool, str]:
        """Safe state now: goals are broken off, the driver is called at once.

        After a stop by others the device takes no more goals until its lease is taken anew, since
        its holder does not know of the stop and would send the next goal milliseconds later; nor
        does one whose lease has lapsed and who is about to come back.
        """
        if by_others:
            self._closed_to_goals = (
                f"{self.name} was stopped by somebody else at {time.strftime('%H:%M:%S')}; "
                f"take its lease anew to go on"
            )
            # Left unwritten it costs a run that is resumed later the sight of this stop.
            with contextlib.suppress(LedgerFault):
                self._ledger.skip_epoch(self.name)
        self._interrupt()
        self._status.changed()
        return await self._safety.confirmed(timeout_s)

    def _interrupt(self) -> None:
        """Break off what runs; it may undo the safe state until it has ended, so safe once more."""
        if self.running:
            for execution in self.running.values():
                execution.interrupt()
            self._start(self._safe_when_idle())

    async def _safe_when_idle(self) -> None:
        await self._until_idle(FINISH_S)
        await self._safety.confirmed(FINISH_S)

    async def _until_idle(self, timeout_s: float) -> None:
        ends = [ex.task for ex in self.running.values() if ex.task is not None]
        if ends:
            await asyncio.wait(ends, timeout=timeout_s)

    def _lapsed(self) -> None:
        self._start(self._calm_down())

    async def _calm_down(self) -> None:
        """What the contract wants when nobody answers for the device any more."""
        match self._contract.on_lease_lapse:
            case "cancel":
                for execution in list(self.running.values()):
                    execution.cancel()
            case "safe":
                self._interrupt()
                self._safety.begin()
            case "finish":
                pass
        await self._safe_when_idle()
        if self.lease.holder is None:
            self._unlease()

    def _unlease(self) -> None:
        # Left unwritten it costs nothing but one more safe state when the server starts again.
        with contextlib.suppress(LedgerFault):
            self._ledger.unlease(self.name)

    def _start(self, work: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task
