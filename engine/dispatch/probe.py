"""The fate of an action whose end was not seen: a question to its device, and what it proves.

A contract's probe is a pure action that reports the last time the action was done and, in the result
`goal_id`, the goal that requested it. Our goal: it happened, and the probe's other fields are the
result. Another goal, or empty for a device that certainly never did it: it did not happen. Null, for
a device that does not remember the goal, proves nothing; nor does an execution that may hide an
earlier one.

Nor does a goal that its server never had: somebody else reaches the instrument past this server, by
another one or by hand, and may have done so before us or after.

Where the server's ledger was replaced by an older copy or another, only our goal proves anything: a
driver keeps its own memory beside the ledger, and that may be as old.
"""

from dataclasses import replace
from typing import Any

from ...drivers.client.client import Outcome, ServerUnreachable
from ...schemas import journal as j
from ...schemas.messages import GoalError
from ..journal.course import split_goal_id
from ..journal.history import History
from ..lab.bind import BoundRole
from .device_handle import DeviceHandle
from .request import Request

PROBE_TIMEOUT_S = 60.0
"""How long a probe may take at least; longer where its contract's `duration` says so."""
PROBE = "/probe"
STRANGER = "Stranger"
"""The error beside the answer of a probe that denies our goal, and proves nothing by it: it names a
goal which its server never had, or its server has another ledger than when ours was sent."""


def probe_path(goal_id: str) -> str:
    """The path of a goal's probes in the run."""
    return f"{goal_id.partition('/')[2]}{PROBE}"


def unknown_path(goal_id: str) -> str:
    """The path of the question to a person about a goal's fate."""
    return f"{goal_id.partition('/')[2]}/unknown"


def probe_request(history: History, role: BoundRole, goal_id: str, action: str) -> Request | None:
    """The next probe of a goal's fate; None if its action has none."""
    name = role.contract.actions[action].probe
    if name is None:
        return None
    path, probe = probe_path(goal_id), role.contract.actions[name]
    attempt = 1 + max(history.past.goals.get(path, {0: None}))
    return Request(
        goal_id=f"{goal_id.partition('/')[0]}/{path}/{attempt}", path=path, role=role,
        action_name=name, action=probe, params={},
        timeout_s=max(PROBE_TIMEOUT_S, probe.hung_after_s({}) or 0.0),
    )  # fmt: skip


def told_before(history: History, goal_id: str) -> dict[str, Any] | None:
    """What a probe of this goal has already reported: it was asked in time, and is valid."""
    past = history.past.newest_success(probe_path(goal_id))
    return told_by(past.ended) if past is not None and past.ended is not None else None


def told_by(ended: Outcome | j.GoalEnded) -> dict[str, Any] | None:
    """What a probe reports; without the goal, where that was seen to prove nothing."""
    if ended.state != "SUCCEEDED" or ended.error is None or ended.error.name != STRANGER:
        return ended.result if ended.state == "SUCCEEDED" else None
    return {**(ended.result or {}), "goal_id": None}


async def checked_with_server(
    request: Request, outcome: Outcome, client: DeviceHandle, history: History
) -> Outcome:
    """The outcome of a probe, with an error if what it says does not deny the goal that is asked about."""
    newest = (outcome.result or {}).get("goal_id")
    own, asked = request.goal_id.partition("/")[0], request.path.removesuffix(PROBE)
    probed = asked != request.path and outcome.state == "SUCCEEDED" and outcome.error is None
    if not probed or newest is None or newest == f"{own}/{asked}":
        return outcome
    past = history.past.goal(*split_goal_id(f"{own}/{asked}"))
    if not client.continues or (past is not None and not history.is_remembered(past.sent)):
        words = (
            "what it says proves nothing: its server's ledger was replaced, or put back from an older "
            "copy, and what the driver itself remembers may be as old"
        )
        return _proves_nothing(outcome, words)
    if not newest or str(newest).partition("/")[0] == own:
        return outcome
    try:
        if await client.knows(str(newest)):
            return outcome
        words = f"its server never had the goal {newest}: somebody else uses the instrument, too"
    except ServerUnreachable as fault:
        words = f"its server could not be asked about the goal {newest}: {fault}"
    return _proves_nothing(outcome, words)


def _proves_nothing(outcome: Outcome, words: str) -> Outcome:
    return replace(outcome, error=GoalError(name=STRANGER, message=words, happened="yes"))


def what_it_proves(
    history: History, role: BoundRole, goal_id: str, told: dict[str, Any] | None
) -> bool | None:
    """Whether a goal's action happened; None if the answer proves nothing.

    A newer execution may hide an earlier one: it may be our own, requested later, or that of another
    client, which may have held the device in between. On a device that does several things at a time
    the order of requests is not that of executions: only the goal's own id proves anything.
    """
    if told is None or told.get("goal_id") is None:
        return None
    newest = str(told["goal_id"])
    if newest == goal_id:
        return True
    past = history.past.goal(*split_goal_id(goal_id))
    if past is None or role.contract.concurrent or _overtakes(role, past.sent.action):
        return None
    if not newest:
        return False
    if newest.partition("/")[0] == goal_id.partition("/")[0]:
        earlier = history.was_before(past.sent.device, newest, goal_id)
    else:
        earlier = history.held_since(past.sent)
    return False if earlier else None


def _overtakes(role: BoundRole, name: str) -> bool:
    action = role.contract.actions.get(name)
    return action is None or action.meanwhile
