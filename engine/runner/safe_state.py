"""Safe state, and the goals that an earlier engine session left behind."""

from collections.abc import Coroutine, Mapping
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ...drivers.client.client import ServerUnreachable
from ...schemas import journal as j
from ..control.control import Control
from ..dispatch.device_handle import DeviceHandle
from ..dispatch.dispatcher import Dispatcher
from ..dispatch.probe import PROBE, PROBE_TIMEOUT_S, probe_request, told_before, unknown_path
from ..dispatch.request import Request
from ..journal.history import LAPSED, RESTARTED, STRANGER
from ..journal.journal import DiskFull, JournalFault
from ..journal.past import PastGoal
from ..run.run import Run
from ..tree.tick import Ended, run_tree

STEP_S = 0.5
"""How soon a goal of an earlier engine is cancelled that could not be followed at once."""


async def to_safe_state(
    run: Run, dispatcher: Dispatcher, clients: Mapping[str, DeviceHandle]
) -> set[str]:
    """Bring every device that was used to its safe state; report and return which did not confirm."""
    unsafe: set[str] = set()
    safe_states = {role.device: role.contract.safe_state for role in run.roles.values()}
    for device in sorted(run.history.boots):
        if not safe_states.get(device):
            continue
        try:
            confirmed, message = (await clients[device].stop(device)).get(
                device, (False, "no answer")
            )
        except (ServerUnreachable, OSError, TimeoutError) as fault:
            confirmed, message = False, str(fault)
        if not confirmed:
            unsafe.add(device)
            run.log(f"{device} did not confirm its safe state: {message}. Go and look.")
        run.tell("safe", device, "confirmed" if confirmed else "unconfirmed", message)
        run.record(j.SafeState(device=device, confirmed=confirmed, message=message))
    try:
        run.journal.flush()
    except (DiskFull, JournalFault) as fault:
        run.log(str(fault))
    return unsafe


async def resolve_goals_in_flight(run: Run, dispatcher: Dispatcher, control: Control) -> None:
    """Determine the fate of goals that were in flight when the engine ended, before anything moves.

    Servers are asked for their outcomes; no goal is sent. If the fate of a `once` action is unknown,
    its probe is sent now: once anything else is done, its answer would prove nothing.
    """

    def resolve(requests: list[Request]) -> Coroutine[Any, Any, Ended]:
        asked = InFlight(run, control, dispatcher, requests)
        return run_tree(asked, run, dispatcher, control, abortable=False)

    await resolve([_adopt(run, goal) for goal in run.history.past.open_goals()])
    probes = [_probe_of(run, goal) for goal in run.history.past.unknown_fates()]
    await resolve([probe for probe in probes if probe is not None])
    if run.journal.unsure:
        await resolve(_newest(run))


def _newest(run: Run) -> list[Request]:
    """What is asked of each instrument where only it can tell that this journal is an older copy."""
    asked = {
        (role.device, action.probe): role
        for role in run.roles.values()
        for action in role.contract.actions.values()
        if action.effect == "once" and action.probe
    }
    found = []
    for (device, name), role in asked.items():
        path = f"main/newest/{device}/{name}/{run.history.resumes}{PROBE}"
        found.append(
            Request(
                goal_id=f"{run.id}/{path}/1", path=path, role=role, action_name=name,
                action=role.contract.actions[name], params={}, timeout_s=PROBE_TIMEOUT_S,
            )
        )  # fmt: skip
    return found


class InFlight(Behaviour):
    """Goals that are asked about, or probes: over when the outcome of each is known.

    If the run is aborted, also before the first tick, those that still run are cancelled.
    """

    def __init__(self, run: Run, control: Control, dispatcher: Dispatcher, requests: list[Request]):
        super().__init__("goals in flight")
        self.run, self.control, self.dispatcher = run, control, dispatcher
        self.requests = requests

    def initialise(self) -> None:
        for request in self.requests:
            self.dispatcher.request(request)

    def update(self) -> Status:
        for request in self._waiting() if self.control.aborted_by else ():
            if request.adopt is None or request.sent_at is not None:
                self.dispatcher.withdraw(request)
            else:  # it can be cancelled once it is followed
                self.run.requests.wake_at(self.run.clock.now() + STEP_S)
        # What was withdrawn before it was sent has ended by now, and nothing else will say so.
        return Status.RUNNING if self._waiting() else Status.SUCCESS

    def _waiting(self) -> list[Request]:
        return [request for request in self.requests if request.outcome is None]


def _probe_of(run: Run, past: PastGoal) -> Request | None:
    role = next((r for r in run.roles.values() if r.device == past.sent.device), None)
    if role is None or past.sent.action not in role.contract.actions:
        return None
    error = past.ended.error if past.ended is not None else None
    known = error is not None and role.contract.actions[past.sent.action].happened(error.name)
    settled = told_before(run.history, past.sent.id) is not None
    if known in ("no", "yes") or settled or unknown_path(past.sent.id) in run.history.past.answers:
        return None
    return probe_request(run.history, role, past.sent.id, past.sent.action)


def touched_since(run: Run, clients: Mapping[str, DeviceHandle]) -> dict[str, str]:
    """Devices whose state may have changed since this run's last lease on them -> why.

    Their servers were restarted, or made them safe when that lease lapsed, or another client has
    held or stopped them: the servers say so, and no clock.
    """
    found: dict[str, str] = {}
    for device, boot in run.history.boots.items():
        client = clients.get(device)
        if client is None:
            continue
        if client.boot != boot:
            found[device] = RESTARTED
        elif run.history.somebody_was_there(device, client.boot, client.epoch(device)):
            found[device] = STRANGER
        elif client.lapsed(device) >= max(run.history.epochs.get(device, {1})):
            found[device] = LAPSED
    return found


def mark_state_lost(run: Run, device: str, reason: str) -> None:
    """Record that what finished steps had set on a device may be lost."""
    run.record(j.Touched(device=device, reason=reason))


def _adopt(run: Run, past: PastGoal) -> Request:
    sent = past.sent
    role = next(role for role in run.roles.values() if role.device == sent.device)
    path = sent.id.partition("/")[2].rpartition("/")[0]
    return Request(
        goal_id=sent.id, path=path, role=role, action_name=sent.action,
        action=role.contract.actions[sent.action], params=sent.params, timeout_s=sent.timeout_s,
        adopt=past,
    )  # fmt: skip
