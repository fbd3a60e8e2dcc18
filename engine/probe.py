"""What became of an action that nobody saw end: a question to its device, and what the answer proves.

A contract's probe is a pure action that tells the newest doing of the thing and the goal that asked
for it, in the result `goal_id`. Ours: it happened, and the probe's other fields are the result.
Another's, or empty for a device that surely never did it: it did not happen. Null, for a device that
does not remember who asked, proves nothing; nor does a doing that may hide an earlier one.
"""

from typing import Any

from ..schemas import journal as j
from .bind import BoundRole
from .history import History, PastGoal, split_goal_id
from .request import Request

PROBE_TIMEOUT_S = 60.0


def probe_path(goal_id: str) -> str:
    """Where the probes of a goal stand in the run."""
    return f"{goal_id.partition('/')[2]}/probe"


def unknown_path(goal_id: str) -> str:
    """Where a person is asked what became of a goal."""
    return f"{goal_id.partition('/')[2]}/unknown"


def probe_request(history: History, role: BoundRole, goal_id: str, action: str) -> Request | None:
    """The next probe after a goal's fate; None where its action has none."""
    name = role.contract.actions[action].probe
    if name is None:
        return None
    path = probe_path(goal_id)
    attempt = 1 + max(history.goals.get(path, {0: None}))
    return Request(
        goal_id=f"{goal_id.partition('/')[0]}/{path}/{attempt}", path=path, role=role,
        action_name=name, action=role.contract.actions[name], params={},
        timeout_s=PROBE_TIMEOUT_S,
    )  # fmt: skip


def told_before(history: History, goal_id: str) -> dict[str, Any] | None:
    """What a probe of this goal has told already: it was asked in time, and stands."""
    past = history.newest_success(probe_path(goal_id))
    return past.ended.result if past is not None and past.ended is not None else None


def keep_answer(history: History, probe: Request) -> None:
    """Let the history know what a probe has told, as if it were the newest thing in the journal."""
    if probe.outcome is None or probe.outcome.state != "SUCCEEDED":
        return
    newest = history.last_n
    sent = j.GoalSent(
        n=newest, id=probe.goal_id, device=probe.device, action=probe.action_name,
        effect=probe.action.effect, boot="", ledger="", epoch=probe.epoch, means=probe.means(),
    )  # fmt: skip
    ended = j.GoalEnded(n=newest, id=probe.goal_id, state="SUCCEEDED", result=probe.outcome.result)
    path, attempt = split_goal_id(probe.goal_id)
    history.goals.setdefault(path, {})[attempt] = PastGoal(sent, ended)


def what_it_proves(
    history: History, device: str, goal_id: str, epoch: int, told: dict[str, Any] | None
) -> bool | None:
    """Whether a goal's action happened; None where the answer proves nothing.

    A newer doing hides whether there was another before it: one of our own that was asked for
    later, or a stranger's who may have held the device in between.
    """
    if told is None or told.get("goal_id") is None:
        return None
    newest = str(told["goal_id"])
    if newest == goal_id:
        return True
    if not newest:
        return False
    if newest.partition("/")[0] == goal_id.partition("/")[0]:
        earlier = history.was_before(device, newest, goal_id)
    else:
        earlier = history.held_since(device, epoch)
    return False if earlier else None
