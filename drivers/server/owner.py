"""One owner of a device: what begins on it, what ends, and when it is safe. Read this file first.

The device is OPEN while goals may begin. A lease that ends while goals act makes it LAPSING: they
end as the contract says. A stop makes it STOPPING: they are aborted, and the driver's `safe()` is
called at once, whatever it is doing. Once no goal's code acts any more, the device is made SAFE:
only this `safe()` counts and answers stops, since a goal's last act may undo an earlier one. Then
it is OPEN again, or ENDED. docs/reference/device-server.md draws this.

Others ask (`stop`, `lapse`, `end`, `turn`); one task goes through the states and lets goals begin.
"""

import asyncio
import contextlib
import logging
from collections.abc import Callable
from enum import Enum

from ...schemas.contract import Contract
from ...system.tasks import keep
from ..driver import Driver, GoalContext
from .execution import Execution

OVER = "its lease was over, no engine was in contact"

Word = tuple[bool, str]
"""Whether the driver confirmed the safe state, and a message."""

LOG = logging.getLogger("labrun")


class State(Enum):
    """What a device's owner lets happen on it."""

    OPEN = "goals begin"
    LAPSING = "goals whose lease is over come to their end, no goal begins"
    STOPPING = "goals are aborted, no goal begins"
    SAFE = "no goal acts or begins while the driver makes the device safe"
    ENDED = "no goal begins any more"


class Owner:
    """Owns one device from its opening to its close."""

    def __init__(
        self,
        device: str,
        driver: Driver,
        contract: Contract,
        changed: Callable[[], None],
        calmed: Callable[[], None],
    ) -> None:
        """Calls `changed` when the device's status may have, `calmed` when a lapse is made safe."""
        self.device = device
        self.state = State.OPEN
        self.goals: dict[str, Execution] = {}
        self.stops = 0
        self.lapsed = 0
        """The epoch of the newest lease after which the device was, or is being, made safe."""
        self._driver = driver
        self._contract = contract
        self._changed = changed
        self._calmed = calmed
        self._news = asyncio.Event()
        self._asked: list[asyncio.Future[Word]] = []
        self._at_once = False
        self._lapsed = False
        self._ends = False
        self._over = 0

    def open(self) -> asyncio.Task[None]:
        """Begin to own the device; the task ends when it is cancelled."""
        return keep(f"owner of {self.device}", self._own)

    @property
    def at_rest(self) -> bool:
        """Nobody has to wait for a safe state: a goal that comes now begins now."""
        return self.state is State.OPEN and not self._asked and not self._lapsed

    def stop(self, name: str, words: str) -> asyncio.Future[Word]:
        """Abort what runs, by this error, and make the device safe; the future is the answer."""
        self.stops += 1
        for execution in self.goals.values():
            execution.cut_by(name, words)
        answer: asyncio.Future[Word] = asyncio.get_running_loop().create_future()
        self._asked.append(answer)
        self._at_once = True
        self._news.set()
        return answer

    def end(self) -> None:
        """Let no goal begin any more."""
        self._ends = True
        self._news.set()

    def fence(self, epoch: int) -> None:
        """What was sent under this lease, or an earlier one, begins no more."""
        self._over = epoch
        self._news.set()

    def lapse(self, epoch: int) -> None:
        """The lease is over: do what the contract requires, then make the device safe."""
        for execution in self.goals.values():
            match self._contract.on_lease_lapse:
                case "cancel":
                    execution.cancel()
                case "safe":
                    execution.cut_by("Lost", f"{self.device} was made safe: {OVER}")
                    self._at_once = True
                case "finish":
                    pass
        self._lapsed = True
        if self._can_be_made_safe:
            self.lapsed = epoch
        self.fence(epoch)

    async def turn(self, execution: Execution) -> bool:
        """Wait until a goal may begin; False if it must not any more. Then `returned` follows."""
        if not self._may_begin(execution):
            return False
        execution.turn = asyncio.get_running_loop().create_future()
        self._news.set()
        # Something may have come between the owner's word and its hearing it.
        return await execution.turn and self._may_begin(execution)

    def _may_begin(self, execution: Execution) -> bool:
        fenced = self._ends or execution.goal.epoch <= self._over
        return not fenced and not execution.context.cancelled.is_set()

    def returned(self, execution: Execution) -> None:
        """The goal's code has returned, or has not begun: nothing of it acts on the device."""
        execution.turn = None
        if self.state is not State.OPEN:  # otherwise nobody waits for it
            self._news.set()

    async def _own(self) -> None:
        while True:
            if self._asked or self._lapsed:
                await self._make_safe()
            self.state = State.ENDED if self._ends else State.OPEN
            for execution in self.goals.values():
                execution.let_begin(self._may_begin(execution))
            await self._news.wait()
            self._news.clear()

    async def _make_safe(self) -> None:
        self.state = State.STOPPING if self._asked else State.LAPSING
        clock = asyncio.get_running_loop().time
        late: float | None = clock() + self._contract.lapse_grace_s
        while any(execution.acts for execution in self.goals.values()):
            if self._at_once:
                self._at_once = False
                self.state = State.STOPPING
                await self.safe()
            elif late is not None and clock() >= late:
                late, self._at_once = None, True
                for execution in self.goals.values():
                    execution.cut_by("Lost", f"{self.device} was made safe: {OVER}")
            else:
                with contextlib.suppress(TimeoutError):
                    async with asyncio.timeout_at(late):
                        await self._news.wait()
                self._news.clear()
        self.state = State.SAFE
        word = await self.safe()
        # Nothing has acted since this safe() began, so it also answers what was asked meanwhile.
        for answer in self._asked:
            answer.set_result(word)
        self._asked.clear()
        self._at_once = False
        if self._lapsed:
            self._lapsed = False
            self._calmed()

    @property
    def _has_own_safe(self) -> bool:
        return type(self._driver).safe is not Driver.safe

    @property
    def _can_be_made_safe(self) -> bool:
        """Otherwise a lapse leaves the device as it is: a balance, whose pan must not be zeroed again."""
        return self._has_own_safe or bool(self._contract.safe_state)

    async def safe(self) -> Word:
        """Call the driver, whose answer is whether the device is in its safe state."""
        try:
            if self._has_own_safe:
                await self._driver.safe()
            else:
                for action in self._contract.safe_state:
                    await self._driver.method(action)(GoalContext(f"safe:{action}"))
        except Exception as fault:  # whatever it is, the device is then not known to be safe
            LOG.exception("%s could not be made safe", self.device)
            return False, f"{self.device} may not be safe: {type(fault).__name__}: {fault}"
        finally:
            self._changed()
        return True, f"{self.device} is in its safe state"
