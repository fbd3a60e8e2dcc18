"""The services and topics behind a ROS 2 action, for clients without support for actions.

Those of ROS 2 itself (design.ros2.org, "Actions"): `_action/send_goal`, `_action/get_result`,
`_action/cancel_goal`, `_action/feedback`, `_action/status`. roslib 1.4 sends goals by them, and
`cancelAllGoals` of roslib 2 is a call of `cancel_goal` without an id.
"""

from abc import abstractmethod
from typing import Any

from ..interfaces.kinds import Field, Message, ServiceKind
from ..interfaces.own_kinds import CANCEL_GOAL, GOAL_STATUS_ARRAY, TIME, UUID
from ..offers.goals import Goal, Goals
from ..offers.offer import Action, Offers, Refused, Service, Topic, Values

NOBODY = bytes(16)
ERROR_NONE, ERROR_REJECTED, ERROR_UNKNOWN_GOAL_ID, ERROR_GOAL_TERMINATED = range(4)


class _Hidden(Service):
    def __init__(self, name: str, action: Action, hidden: "Hidden") -> None:
        self.name = name
        self.action = action
        self.hidden = hidden
        self.goals = hidden.goals
        self.kind = self.make_kind(action.kind.package, action.kind.name)

    @abstractmethod
    def make_kind(self, package: str, name: str) -> ServiceKind: ...


class SendGoal(_Hidden):
    """`{goal_id, goal}` -> `{accepted, stamp}`."""

    def make_kind(self, package: str, name: str) -> ServiceKind:
        goal = Field("goal", self.action.kind.goal.name, "goal", message=self.action.kind.goal)
        return ServiceKind(
            package, f"{name}_SendGoal",
            Message(package, f"{name}_SendGoal_Request", (_id_field(), goal)),
            Message(package, f"{name}_SendGoal_Response", (
                Field("accepted", "bool", "accepted"), Field("stamp", "Time", "stamp", message=TIME),
            )),
            group="action",
        )  # fmt: skip

    async def answer(self, values: Values) -> Values:
        id = _uuid(values.get("goal_id"))
        if id == NOBODY:
            raise Refused("goal_id.uuid must be 16 numbers from 0 to 255, not all of them 0")
        topic = self.hidden.feedback(self.action)

        def tell(feedback: Values) -> None:
            topic.publish({"goal_id": {"uuid": list(id)}, "feedback": feedback})

        try:
            goal = await self.goals.begin(self.action, values.get("goal") or {}, tell, id)
        except Refused as fault:
            # A bool cannot carry the reason; as an error it reaches the client's error callback.
            raise Refused(f"rejected: {fault}") from fault
        return {"accepted": True, "stamp": stamp(goal.began)}


class GetResult(_Hidden):
    """`{goal_id}` -> `{status, result}`, once the goal has ended."""

    def make_kind(self, package: str, name: str) -> ServiceKind:
        result = self.action.kind.result
        return ServiceKind(
            package, f"{name}_GetResult",
            Message(package, f"{name}_GetResult_Request", (_id_field(),)),
            Message(package, f"{name}_GetResult_Response", (
                Field("status", "int8", "status"), Field("result", result.name, "result", message=result),
            )),
            group="action",
        )  # fmt: skip

    async def answer(self, values: Values) -> Values:
        goal = self.goals.known(_uuid(values.get("goal_id")))
        if goal is None or goal.action is not self.action:
            raise Refused(f"{self.action.name} has no goal with that id")
        end = await goal.end()
        return {"status": goal.status, "result": end.result}


class CancelGoal(_Hidden):
    """`{goal_info}` -> `{return_code, goals_canceling}`; no id and no time: all goals of the action."""

    def make_kind(self, package: str, name: str) -> ServiceKind:
        return CANCEL_GOAL

    async def answer(self, values: Values) -> Values:
        info = values.get("goal_info")
        info = info if isinstance(info, dict) else {}
        id, until = _uuid(info.get("goal_id")), _seconds(info.get("stamp"))
        running = [goal for goal in self.goals.of(self.action) if goal.ended is None]
        chosen = [
            g
            for g in running
            if id in (NOBODY, g.id) and (id != NOBODY or not until or g.began <= until)
        ]
        if id != NOBODY and not chosen:
            known = self.goals.known(id)
            code = ERROR_UNKNOWN_GOAL_ID if known is None else ERROR_GOAL_TERMINATED
            return {"return_code": code, "goals_canceling": []}
        canceled = [goal for goal in chosen if not self.goals.cancel(goal)]
        code = ERROR_REJECTED if chosen and not canceled else ERROR_NONE
        return {"return_code": code, "goals_canceling": [goal_info(goal) for goal in canceled]}


SERVICES = {"send_goal": SendGoal, "get_result": GetResult, "cancel_goal": CancelGoal}


class Hidden:
    """The services and topics behind the actions, created on request."""

    def __init__(self, offers: Offers, goals: Goals) -> None:
        self.goals = goals
        self._offers = offers
        self._status: dict[Action, Topic] = {}
        self._feedback: dict[Action, Topic] = {}
        goals.on_change(self._changed)

    def service(self, name: str) -> Service | None:
        """The service of this name behind one of the actions."""
        action, verb = self._split(name)
        return SERVICES[verb](name, action, self) if action and verb in SERVICES else None

    def topic(self, name: str) -> Topic | None:
        """The topic of this name behind one of the actions."""
        action, verb = self._split(name)
        if action is None or verb not in ("feedback", "status"):
            return None
        return self.feedback(action) if verb == "feedback" else self.status(action)

    def feedback(self, action: Action) -> Topic:
        """Feedback of the goals that were sent by `_action/send_goal`."""
        if action not in self._feedback:
            kind = action.kind
            message = Message(kind.package, f"{kind.name}_FeedbackMessage", (
                _id_field(), Field("feedback", kind.feedback.name, "feedback", message=kind.feedback),
            ), group="action")  # fmt: skip
            self._feedback[action] = Topic(f"{action.name}/_action/feedback", message)
        return self._feedback[action]

    def status(self, action: Action) -> Topic:
        """The goals of an action, from all clients."""
        if action not in self._status:
            self._status[action] = Topic(f"{action.name}/_action/status", GOAL_STATUS_ARRAY)
            self._tell(action)
        return self._status[action]

    def _split(self, name: str) -> tuple[Action | None, str]:
        action, _, verb = name.rpartition("/_action/")
        return self._offers.actions.get(action), verb

    def _changed(self, goal: Goal) -> None:
        if goal.action in self._status:
            self._tell(goal.action)

    def _tell(self, action: Action) -> None:
        listed = [
            {"goal_info": goal_info(goal), "status": goal.status} for goal in self.goals.of(action)
        ]
        self._status[action].publish({"status_list": listed})


def goal_info(goal: Goal) -> Values:
    """`action_msgs/GoalInfo`."""
    return {"goal_id": {"uuid": list(goal.id)}, "stamp": stamp(goal.began)}


def stamp(at: float) -> Values:
    """`builtin_interfaces/Time`."""
    return {"sec": int(at), "nanosec": int(at % 1 * 1e9)}


def _id_field() -> Field:
    return Field("goal_id", "UUID", "goal_id", message=UUID)


def _uuid(value: Any) -> bytes:
    """Sixteen bytes; NOBODY if there are none. Raises Refused."""
    given = value.get("uuid") if isinstance(value, dict) else value
    if given is None or given == []:
        return NOBODY
    good = isinstance(given, list) and len(given) == 16
    if not good or not all(type(byte) is int and 0 <= byte < 256 for byte in given):
        raise Refused("a uuid must be 16 numbers from 0 to 255")
    return bytes(given)


def _seconds(value: Any) -> float:
    if not isinstance(value, dict):
        return 0.0
    parts = [value.get("sec", 0), value.get("nanosec", 0)]
    if not all(isinstance(part, int) for part in parts):
        raise Refused("a stamp must be integers: sec and nanosec")
    return parts[0] + parts[1] / 1e9
