"""One of our actions as an rclpy action server."""

# rclpy exists only where ROS is installed.
# pyright: reportMissingImports=false

import logging
from typing import Any

from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node

from ..offers.goals import Goal, Goals
from ..offers.offer import Action, Refused, Values
from .crossing import Crossing
from .messages import fill, from_message

ORPHAN_S = 5.0
LOG = logging.getLogger(__name__)


class ActionFace:
    """Goals start in the goal callback, so that ROS sees a device's refusal as a rejection."""

    def __init__(
        self, node: Node, action: Action, cls: Any, goals: Goals, crossing: Crossing
    ) -> None:
        self.action = action
        self._cls = cls
        self._goals = goals
        self._crossing = crossing
        self._begun: dict[int, _Begun] = {}
        self._handles: dict[bytes, Goal] = {}
        self.server = ActionServer(
            node,
            cls,
            action.name[1:],  # relative: the node may have a namespace
            self._execute,
            goal_callback=self._goal,
            handle_accepted_callback=self._accepted,
            cancel_callback=self._cancel,
        )

    async def _goal(self, request: Any) -> GoalResponse:
        begun = _Begun(request, self)
        values = from_message(self.action.kind.goal, request)
        try:
            begun.goal = await self._crossing.over(self._begin(values, begun))
        except Refused as fault:
            LOG.warning("%s: a goal is rejected: %s", self.action.name, fault)
            return GoalResponse.REJECT
        except Exception:  # ROS has to get an answer, and the log says why
            LOG.exception("%s: a goal could not be started", self.action.name)
            return GoalResponse.REJECT
        # The execute callback gets the same request object, which has no id before that.
        self._begun[id(request)] = begun
        return GoalResponse.ACCEPT

    async def _begin(self, values: Values, begun: "_Begun") -> Goal:
        goal = await self._goals.begin(self.action, values, begun.tell)
        self._crossing.loop.call_later(ORPHAN_S, self._cancel_orphan, begun, goal)
        return goal

    def _cancel_orphan(self, begun: "_Begun", goal: Goal) -> None:
        """Two requests with one id: rclpy drops the second after it was started."""
        if begun.handle is None:
            self._begun.pop(id(begun.request), None)
            self._goals.cancel(goal)

    def _accepted(self, handle: ServerGoalHandle) -> None:
        # A cancel may arrive before it is executed, so it is registered from here on.
        begun = self._begun.pop(id(handle.request))
        assert begun.goal is not None
        self._handles[bytes(handle.goal_id.uuid)] = begun.goal
        begun.pick_up(handle)
        handle.execute()

    async def _execute(self, handle: ServerGoalHandle) -> Any:
        key = bytes(handle.goal_id.uuid)
        goal = self._handles[key]
        try:
            # A goal that has already ended needs no round trip.
            end = goal.known_end() if goal.task.done() else await self._crossing.over(goal.end())
        finally:
            del self._handles[key]
        result = fill(self.action.kind.result, self._cls.Result(), end.result)
        if end.state == "SUCCEEDED":
            handle.succeed()
        elif end.state == "CANCELED" and handle.is_cancel_requested:
            handle.canceled()
        else:
            handle.abort()
        return result

    def _cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        goal = self._handles.get(bytes(handle.goal_id.uuid))
        if goal is None or not self.action.can_cancel:
            return CancelResponse.REJECT
        self._crossing.loop.call_soon_threadsafe(self._goals.cancel, goal)
        return CancelResponse.ACCEPT

    def publish(self, handle: ServerGoalHandle, values: Values) -> None:
        """Feedback, from any thread."""
        handle.publish_feedback(fill(self.action.kind.feedback, self._cls.Feedback(), values))


class _Begun:
    """A goal between its request and its handle; its feedback waits meanwhile."""

    def __init__(self, request: Any, face: ActionFace) -> None:
        self.request = request
        self.goal: Goal | None = None
        self.handle: ServerGoalHandle | None = None
        self._face = face
        self._waiting: list[Values] = []

    def tell(self, values: Values) -> None:
        if self.handle is None:
            self._waiting.append(values)
        elif self.handle.is_active:
            self._face.publish(self.handle, values)

    def pick_up(self, handle: ServerGoalHandle) -> None:
        self.handle = handle
        while self._waiting:
            self._face.publish(handle, self._waiting.pop(0))
