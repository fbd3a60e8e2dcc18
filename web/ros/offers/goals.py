"""The goals under way: started or refused, cancelled, ended; their client may be gone meanwhile."""

import asyncio
import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from uuid import uuid4

from ....system.tasks import end, first_of, spawn
from ..interfaces.values import to_ros
from .offer import Action, End, Refused, Values, Work

EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = range(2, 7)
STATUS = {"SUCCEEDED": SUCCEEDED, "CANCELED": CANCELED, "ABORTED": ABORTED}
"""Numbers of action_msgs/msg/GoalStatus."""
KEPT_S, MOST_KEPT = 900.0, 1000
"""How long ROS keeps a result that nobody has fetched, and how many we keep."""
MOST_RUNNING = 200
LOG = logging.getLogger(__name__)


@dataclass(slots=True, eq=False)
class Goal:
    """One goal of one action."""

    id: bytes
    action: Action
    work: Work
    task: asyncio.Task[End]
    began: float = field(default_factory=time.time)
    ended: float | None = None
    status: int = EXECUTING

    async def end(self) -> End:
        """Wait for its end; cancelling the wait leaves the goal alone."""
        await asyncio.wait({self.task})
        return self.known_end()

    def known_end(self) -> End:
        """Its end, once its task is done."""
        if self.task.cancelled():
            return aborted(self.action, "Stopped", "the lab is no longer offered to ROS", "unknown")
        return self.task.result()


class Goals:
    """Every goal that was started and is still kept, by its sixteen-byte id.

    One that its action has not taken after `begin_s` is refused.
    """

    def __init__(self, begin_s: float = 60.0) -> None:
        self._begin_s = begin_s
        self._goals: dict[bytes, Goal] = {}
        self._changed: list[Callable[[Goal], None]] = []

    def of(self, action: Action) -> list[Goal]:
        """The goals of one action, oldest first."""
        self._forget()
        return [goal for goal in self._goals.values() if goal.action is action]

    def known(self, id: bytes) -> Goal | None:
        """One of them, or None."""
        return self._goals.get(id)

    def on_change(self, listener: Callable[[Goal], None]) -> None:
        """Call `hear` when a goal starts, is cancelled or ends."""
        self._changed.append(listener)

    async def begin(
        self,
        action: Action,
        values: Values,
        tell: Callable[[Values], None],
        id: bytes | None = None,
    ) -> Goal:
        """Start a goal and wait until its action has accepted it; raises Refused."""
        self._forget()
        id = id or uuid4().bytes
        if id in self._goals:
            raise Refused(f"a goal with the id {id.hex()} already exists")
        if sum(goal.ended is None for goal in self._goals.values()) >= MOST_RUNNING:
            raise Refused(f"{MOST_RUNNING} goals are already under way")
        work = Work(id.hex(), values, tell)
        name = f"{action.name} {work.id}"
        goal = Goal(id, action, work, spawn(name, _carried(action, work), expected=(Refused,)))
        self._goals[id] = goal
        try:
            await self._until_begun(goal)
        except BaseException:  # a cancel as well
            del self._goals[id]
            await end(goal.task)
            raise
        self._tell(goal)
        goal.task.add_done_callback(lambda _: self._ended(goal))
        return goal

    def cancel(self, goal: Goal) -> str:
        """Cancel a goal; returns why it cannot be cancelled, or an empty string."""
        if goal.ended is not None or goal.task.done():
            return "the goal has ended"
        if not goal.action.can_cancel:
            return f"{goal.action.name} cannot be cancelled; it ends by itself"
        if goal.status != CANCELING:
            goal.status = CANCELING
            goal.work.cancelled.set()
            self._tell(goal)
        return ""

    async def close(self) -> None:
        """Cancel what can be cancelled, wait a moment, and leave no task."""
        running = [goal for goal in self._goals.values() if not goal.task.done()]
        for goal in running:
            self.cancel(goal)
        if running:
            wait_s = max(goal.action.close_s for goal in running)
            await asyncio.wait([goal.task for goal in running], timeout=wait_s)
        await end(*(goal.task for goal in running))

    async def _until_begun(self, goal: Goal) -> None:
        begun = spawn(f"the begin of {goal.work.id}", goal.work.begun.wait())
        try:
            await first_of({begun, goal.task}, self._begin_s)
            if goal.task.done():
                goal.task.result()  # a refusal
            elif not goal.work.begun.is_set():
                raise Refused(f"{goal.action.name} did not start within {self._begin_s:g} s")
        finally:
            await end(begun)

    def _ended(self, goal: Goal) -> None:
        if goal.task.cancelled():
            goal.status = ABORTED
        else:
            goal.status = STATUS[goal.task.result().state]
        goal.ended = time.monotonic()
        self._tell(goal)

    def _tell(self, goal: Goal) -> None:
        for listener in self._changed:
            listener(goal)

    def _forget(self) -> None:
        ended = [(g.ended, id) for id, g in self._goals.items() if g.ended is not None]
        over = time.monotonic() - KEPT_S
        many = sorted(ended)[: max(0, len(ended) - MOST_KEPT)]
        for id in {id for at, id in ended if at < over} | {id for _, id in many}:
            del self._goals[id]


async def _carried(action: Action, work: Work) -> End:
    try:
        return await action.carry(work)
    except Refused:
        if not work.begun.is_set():
            raise
        LOG.exception("%s refused a goal that it had started", action.name)
    except Exception:  # waiting clients still get an end; the internal error is in the log
        LOG.exception("%s failed", action.name)
        if not work.begun.is_set():
            raise Refused(
                f"an internal error in labrun prevented {action.name} from starting"
            ) from None
    return aborted(action, "Fault", "an internal error in labrun; see its log", "unknown")


def aborted(action: Action, name: str, message: str, happened: str, **data: object) -> End:
    """The end of a goal that failed."""
    return End("ABORTED", result_of(action, dict(data), name, message, happened))


def result_of(
    action: Action, data: Values, name: str = "", message: str = "", happened: str = ""
) -> Values:
    """Every field of an action's result."""
    said = {"@error_name": name, "@error_message": message, "@error_happened": happened}
    return to_ros(action.kind.result, {**data, **said})
