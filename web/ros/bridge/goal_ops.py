"""Goals: `send_action_goal`, `cancel_action_goal`, and their answers.

As in rosbridge_suite 2.1: a goal that ended gives `result: true` with its status and every field of
its result; one that could not start gives `result: false` with a sentence. A goal that its server
rejects is also answered, whereas rosbridge_suite stays silent for ever.
"""

from dataclasses import dataclass
from typing import Any

from ....engine.language.suggest import did_you_mean
from ..interfaces.kinds import same_type
from ..offers.goals import STATUS, Goal
from ..offers.offer import Action, Refused, Values
from .client import Client, Message
from .fragments import fragment_size
from .frames import Misformed, may, want

UNKNOWN = 0


@dataclass(slots=True)
class Sent:
    """A goal of one client: before it has started a cancel request can only be noted."""

    goal: Goal | None = None
    cancel_wanted: bool = False


def send_action_goal(client: Client, message: Message) -> None:
    """Start a goal; feedback and result carry the client's id."""
    name = want(message, "action", str, "an action's name")
    id = may(message, "id", (str, int), "a text")
    size = fragment_size(message)
    answer = _Answer(client, name, id, size)
    try:
        action = _action(client, name, message.get("action_type"))
        values = may(message, "args", (dict, list), "an object", {})
        feedback = may(message, "feedback", bool, "true or false", False)
    except (Misformed, Refused) as fault:
        answer.refuse(str(fault))
        return
    key = str(id)
    if id is not None and key in client.goals:
        answer.refuse(f"a goal with the id {key} is already under way")
        return
    sent = Sent()
    if id is not None:
        client.goals[key] = sent
    tell = answer.feedback if feedback else lambda values: None
    # An empty list stands for no arguments, as in a service call.
    client.do(f"a goal of {name}", _carried(client, key, sent, action, values or {}, tell, answer))


def cancel_action_goal(client: Client, message: Message) -> None:
    """Cancel a goal of this client; a successful request has no answer."""
    want(message, "action", str, "an action's name")
    key = str(want(message, "id", (str, int), "the id of the goal"))
    sent = client.goals.get(key)
    if sent is None:
        raise Misformed(f"you have no goal {key} under way")
    sent.cancel_wanted = True
    if sent.goal is not None:
        _cancel(client, sent.goal, key)


def _action(client: Client, name: str, type: Any) -> Action:
    action = client.rooms.action(name)
    if action is None:
        hint = did_you_mean(name, client.rooms.offers.actions)
        raise Refused(f"there is no action {name}{hint}; rosapi/action_servers lists them")
    if type is not None and not same_type(type, action.kind.type):
        raise Refused(f"{name} is a {action.kind.type}, not a {str(type)[:100]}")
    return action


async def _carried(
    client: Client, key: str, sent: Sent, action: Action, values: Any, tell: Any, answer: "_Answer"
) -> None:
    try:
        sent.goal = await client.rooms.goals.begin(action, values, tell)
        if sent.cancel_wanted:
            _cancel(client, sent.goal, key)
        end = await sent.goal.end()
    except Refused as fault:
        answer.refuse(str(fault))
    else:
        answer.end(STATUS[end.state], end.result)
    finally:
        if client.goals.get(key) is sent:
            del client.goals[key]


def _cancel(client: Client, goal: Goal, key: str) -> None:
    against = client.rooms.goals.cancel(goal)
    if against:
        client.complain(against, key)


@dataclass(frozen=True, slots=True)
class _Answer:
    client: Client
    action: str
    id: Any
    size: int | None

    def feedback(self, values: Values) -> None:
        self.client.send(self._with("action_feedback", values=values), self.size, droppable=True)

    def end(self, status: int, result: Values) -> None:
        self.client.send(
            self._with("action_result", values=result, status=status, result=True), self.size
        )

    def refuse(self, words: str) -> None:
        self.client.send(
            self._with("action_result", values=words, status=UNKNOWN, result=False), self.size
        )

    def _with(self, op: str, **more: Any) -> Message:
        said = {"op": op, "action": self.action, **more}
        return said if self.id is None else {**said, "id": self.id}
