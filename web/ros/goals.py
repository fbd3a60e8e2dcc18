"""The goals under way: begun or refused, cancelled, ended; whoever asked may be gone meanwhile."""

import asyncio
import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from uuid import uuid4

from .offer import Action, End, Refused, Values, Work
from .values import to_ros

ACCEPTED, EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = range(1, 7)
STATUS = {"SUCCEEDED": SUCCEEDED, "CANCELED": CANCELED, "ABORTED": ABORTED}
"""Numbers of action_msgs/msg/GoalStatus."""
KEPT_S, MOST_KEPT = 900.0, 1000
"""How long ROS keeps a result that nobody has asked for, and how many we keep."""
MOST_RUNNING = 200
BEGIN_S = 30.0
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
            return aborted(self.action, "Stopped", "the lab is offered to ROS no more", "unknown")
        return self.task.result()


class Goals:
    """Every goal that was begun and is not forgotten yet, by its sixteen bytes."""

    def __init__(self) -> None:
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
        """Be told when a goal begins, is cancelled or ends."""
        self._changed.append(listener)

    async def begin(
        self,
        action: Action,
        values: Values,
        tell: Callable[[Values], None],
        id: bytes | None = None,
    ) -> Goal:
        """Begin a goal and wait until its action has taken it; raises Refused."""
        self._forget()
        id = id or uuid4().bytes
        if id in self._goals:
            raise Refused(f"a goal with the id {id.hex()} is known already")
        if sum(goal.ended is None for goal in self._goals.values()) >= MOST_RUNNING:
            raise Refused(f"{MOST_RUNNING} goals are under way already")
        work = Work(id.hex(), values, tell)
        goal = Goal(id, action, work, asyncio.create_task(_carried(action, work)))
        self._goals[id] = goal
        try:
            await self._until_begun(goal)
        except BaseException:
            del self._goals[id]
            goal.task.cancel()
            await asyncio.gather(goal.task, return_exceptions=True)
            raise
        self._tell(goal)
        goal.task.add_done_callback(lambda _: self._ended(goal))
        return goal

    def cancel(self, goal: Goal) -> str:
        """Ask for a goal's end; what stands against it, in words, or nothing."""
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
        for goal in running:
            goal.task.cancel()
        await asyncio.gather(*(goal.task for goal in running), return_exceptions=True)

    async def _until_begun(self, goal: Goal) -> None:
        begun = asyncio.create_task(goal.work.begun.wait())
        try:
            await asyncio.wait(
                {begun, goal.task}, timeout=BEGIN_S, return_when=asyncio.FIRST_COMPLETED
            )
            if goal.task.done():
                goal.task.result()  # a refusal
            elif not goal.work.begun.is_set():
                raise Refused(f"{goal.action.name} did not begin within {BEGIN_S:g} s")
        finally:
            begun.cancel()

    def _ended(self, goal: Goal) -> None:
        if goal.task.cancelled():
            goal.status = ABORTED
        else:
            goal.status = STATUS[goal.task.result().state]
        goal.ended = time.time()
        self._tell(goal)

    def _tell(self, goal: Goal) -> None:
        for listener in self._changed:
            listener(goal)

    def _forget(self) -> None:
        ended = [(g.ended, id) for id, g in self._goals.items() if g.ended is not None]
        over = time.time() - KEPT_S
        many = sorted(ended)[: max(0, len(ended) - MOST_KEPT)]
        for id in {id for at, id in ended if at < over} | {id for _, id in many}:
            del self._goals[id]


async def _carried(action: Action, work: Work) -> End:
    try:
        return await action.carry(work)
    except Refused:
        if not work.begun.is_set():
            raise
        LOG.exception("%s refused a goal that it had begun", action.name)
    except Exception:
        # Whoever waits for it gets an end all the same; the fault is ours, and the log has it.
        LOG.exception("%s failed", action.name)
        if not work.begun.is_set():
            raise Refused(f"a fault in labrun itself kept {action.name} from beginning") from None
    return aborted(action, "Fault", "a fault in labrun itself; its log says more", "unknown")


def aborted(action: Action, name: str, message: str, happened: str, **data: object) -> End:
    """The end of a goal that came to nothing."""
    return End("ABORTED", result_of(action, dict(data), name, message, happened))


def result_of(
    action: Action, data: Values, name: str = "", message: str = "", happened: str = ""
) -> Values:
    """Every field of an action's result."""
    said = {"@error_name": name, "@error_message": message, "@error_happened": happened}
    return to_ros(action.kind.result, {**data, **said})
