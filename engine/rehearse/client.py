"""A device in a rehearsal: a device server without its socket and its disk."""

import asyncio
import math
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...drivers.client.client import Outcome
from ...drivers.client.outcome import lost, outcome_of, refused
from ...drivers.driver import Driver, Place
from ...drivers.server.device import ServedDevice
from ...drivers.server.lease import Refused
from ...drivers.server.ledger import Ledger
from ...drivers.server.status import EVERY_S
from ...drivers.simulated.twins.faults import Faults, chance
from ...drivers.simulated.twins.twin import Twin
from ...drivers.world import WorldInMemory
from ...schemas.contract import Contract
from ...schemas.messages import ENDED, Goal, GoalError, GoalReport, GoalState, LeaseRequest
from ...system.tasks import end, spawn
from ..run.virtual_time import VirtualLoop
from .twin_choice import files_made, repeating

LEASE_S = 3600.0
HANGS_S = 24 * 3600.0
"""How long an action without any timeout may hang in a rehearsal."""


@dataclass(frozen=True, slots=True)
class Trouble:
    """How likely the errors that any action may end with are: action -> error -> probability."""

    rates: Mapping[str, Mapping[str, float]]
    seed: int

    def drawn(self, action: str, goal_id: str) -> str:
        """The error that this goal meets, or nothing; always the same for the same goal."""
        luck = chance(self.seed, "wire", goal_id)
        for error, rate in self.rates.get(action, {}).items():
            if luck < rate:
                return error
            luck -= rate
        return ""

    def before(self, goal_id: str) -> bool:
        """Whether its server was lost before it happened."""
        return chance(self.seed, "lost", goal_id) < 0.5


class NumberedOnly(Ledger):
    """A ledger that keeps no goal: nobody asks a rehearsal's server about one, and no boot follows."""

    def admit(self, goal: Goal, state: GoalState) -> int:
        return self.next_seq()

    def begin(self, goal_id: str) -> None:
        return None

    def end(self, goal_id: str, *how: Any, **more: Any) -> int:
        return self.next_seq()


class RehearsedDevice:
    """In place of `DeviceClient` and its device server, with the driver in this process."""

    def __init__(
        self, place: Place, driver: type[Driver], contract: Contract, faults: Faults,
        trouble: Trouble, *, is_read: bool, repeats: bool,
    ) -> None:  # fmt: skip
        """`is_read`: whether anything in the protocol reads its status; if not, it is asked once.

        `repeats`: whether it may give the answer to a goal to others of its kind: nothing reads it.
        """
        assert isinstance(place.in_memory, WorldInMemory)
        self.url, self._world, self._repeats = "rehearsal", place.in_memory, repeats
        if repeats:
            driver = repeating(driver, contract, place.in_memory)
        self._trouble = trouble
        self._given_up: dict[str, asyncio.Event] = {}
        self.contract = contract
        self.faults = faults
        self._ledger = NumberedOnly(Path(":memory:"))
        self.boot, self.ledger = self._ledger.boot, self._ledger.id
        self.mark, self.continues = self._ledger.mark, True
        self._driver = driver(place)
        self._served = ServedDevice(
            place, self._driver, contract, self._ledger, self._told,
            status_every_s=EVERY_S if is_read else None,
        )  # fmt: skip
        self.on_stopped: Callable[[str, str], None] | None = None
        self.on_touch: Callable[[], None] | None = None
        self.on_told: Callable[[], None] | None = None
        self._status: tuple[dict[str, Any], float] = {}, -math.inf
        self.in_touch = True
        self._epoch = 0
        self._owner = ""
        self._followed: dict[str, tuple[asyncio.Future[GoalReport], Callable]] = {}
        self._renewing: asyncio.Task[None] | None = None

    async def open(self, owner: str) -> None:
        """Open the driver and take the lease, which is kept until the end."""
        await self._served.open(make_safe=False)
        self._told("status", self._served.describe().status, set())
        await self.take_lease(self._served.name, owner)
        self._renewing = spawn("renew the rehearsal's lease", self._renew())

    async def close(self) -> None:
        """Close the driver; leaves no task."""
        await end(self._renewing)
        self._served.lease.close()
        with self._real_time():
            await self._served.close()
        self._ledger.close()

    async def take_lease(self, device: str, owner: str) -> int:
        """Take the lease."""
        self._owner = owner
        request = LeaseRequest(device=device, owner=owner, ttl_s=LEASE_S)
        self._epoch = await self._served.take_lease(request, owner)
        return self._epoch

    async def release(self, device: str) -> None:
        """Give the lease back."""
        await self._served.release(self._owner, self._epoch)

    def newest_status(self, device: str) -> tuple[dict[str, Any], float]:
        """Its newest status, and when it came."""
        return self._status

    def epoch(self, device: str) -> int:
        """The epoch of the lease."""
        return self._epoch

    async def knows(self, goal_id: str) -> bool:
        """Nobody else is there."""
        return True

    def lapsed(self, device: str) -> int:
        """None ever does."""
        return 0

    async def follow(
        self,
        goal: Goal,
        on_report: Callable[[GoalReport], None] = lambda report: None,
        *,
        send: bool = True,
    ) -> Outcome:
        """Run a goal and wait for its end."""
        met = self._trouble.drawn(goal.action, goal.id)
        if met == "Timeout":
            return await self._hang(goal)
        if met in ("Busy", "Rejected"):
            return refused(met.upper(), f"injected: {met} (simulated)", self.boot)
        if met == "Lost" and self._trouble.before(goal.id):
            return lost("injected: its server was lost before it (simulated)", "unknown", self.boot)
        outcome = await self._follow(goal, on_report)
        if met == "Lost":
            return lost("injected: its server was lost after it (simulated)", "unknown", self.boot)
        return outcome

    async def _hang(self, goal: Goal) -> Outcome:
        """It never ends by itself: the run cancels it when its timeout is over."""
        given_up = self._given_up[goal.id] = asyncio.Event()
        try:
            async with asyncio.timeout(HANGS_S):
                await given_up.wait()
        except TimeoutError:
            return lost(f"it has hung for {HANGS_S:g} s (simulated)", "unknown", self.boot)
        finally:
            del self._given_up[goal.id]
        return Outcome("CANCELED", boot=self.boot)

    def _real_time(self) -> AbstractContextManager[None]:
        """Where a thread of its driver computes, no virtual time passes."""
        loop = asyncio.get_running_loop()
        if isinstance(self._driver, Twin) or not isinstance(loop, VirtualLoop):
            return nullcontext()
        return loop.held()

    async def _follow(self, goal: Goal, on_report: Callable[[GoalReport], None]) -> Outcome:
        fault = None if isinstance(self._driver, Twin) else self.faults.drawn(goal.action, goal.id)
        if fault is not None and not fault.after:
            return self._failed(goal, fault)
        end: asyncio.Future[GoalReport] = asyncio.get_running_loop().create_future()
        self._followed[goal.id] = (end, on_report)
        in_threads = _in_threads()
        if goal.files and not self._repeats:
            goal = goal.model_copy(update={"files": files_made(self._world, goal.files)})
        try:
            await self._served.accept(goal, self._owner, self._served.stops)
            outcome = outcome_of(await self._ended(goal, end, in_threads))
        except Refused as refusal:
            return refused(refusal.code, refusal.message, self.boot)
        finally:
            del self._followed[goal.id]
        return outcome if fault is None else self._failed(goal, fault)

    async def _ended(
        self, goal: Goal, end: asyncio.Future[GoalReport], in_threads: int
    ) -> GoalReport:
        if isinstance(self._driver, Twin):
            return await end
        # Real computing takes no virtual time: the contract gives its duration, however quick it is here.
        typical_s = self.contract.actions[goal.action].typical_s(goal.params) or 0.0
        over = asyncio.get_running_loop().time() + typical_s
        await asyncio.wait({end}, timeout=typical_s)
        with self._real_time():
            report = await end
        computed = self._repeats or _in_threads() > in_threads
        if computed and report.state == "SUCCEEDED":
            await asyncio.sleep(over - asyncio.get_running_loop().time())
        return report

    async def cancel(self, goal_id: str) -> None:
        """Cancel a goal."""
        if goal_id in self._given_up:
            self._given_up[goal_id].set()
        execution = self._served.running.get(goal_id)
        if execution is not None:
            execution.cancel()

    async def stop(
        self, device: str | None = None, timeout_s: float = 10.0
    ) -> dict[str, tuple[bool, str]]:
        """Bring the device to its safe state."""
        return {self._served.name: await self._served.stop(timeout_s)}

    def _failed(self, goal: Goal, fault: Any) -> Outcome:
        happened = self.contract.actions[goal.action].happened(fault.error)
        error = GoalError(name=fault.error, message=fault.failure().message, happened=happened)
        return Outcome("ABORTED", error=error, boot=self.boot)

    def _told(self, event: str, payload: dict[str, Any], followers: set[str]) -> None:
        if event == "status" and "fault" not in payload:
            known, self._status = self._status[0], (payload, asyncio.get_running_loop().time())
            if self.on_told is not None and payload != known:
                self.on_told()
        followed = self._followed.get(payload.get("id", "")) if event == "update" else None
        if followed is None:
            return
        end, on_report = followed
        report = GoalReport.model_validate(payload)
        if report.state not in ENDED:
            on_report(report)
        elif not end.done():
            end.set_result(report)

    async def _renew(self) -> None:
        while True:
            await asyncio.sleep(LEASE_S / 3)
            request = LeaseRequest(
                device=self._served.name, owner=self._owner, ttl_s=LEASE_S, epoch=self._epoch
            )
            await self._served.take_lease(request, self._owner)


def _in_threads() -> int:
    loop = asyncio.get_running_loop()
    return loop.in_threads if isinstance(loop, VirtualLoop) else 0
