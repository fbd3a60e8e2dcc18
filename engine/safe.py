"""Safe state, and the goals that an earlier life of the engine left behind."""

from collections.abc import Mapping

from ..drivers.client import Outcome, ServerUnreachable
from ..schemas import journal as j
from .control import Control
from .dispatcher import Dispatcher
from .history import LAPSED, RESTARTED, STRANGER, PastGoal
from .journal import DiskFull, JournalFault
from .probe import keep_answer, probe_request, told_before, unknown_path
from .reached import Reached
from .request import Request
from .run import Run

STEP_S = 0.5
"""How often timeouts are looked after while goals of an earlier engine are waited for."""
LEASE_S = 30.0
"""A device whose engine was away for longer has been put into its safe state by its server."""


async def to_safe_state(run: Run, dispatcher: Dispatcher, clients: Mapping[str, Reached]) -> None:
    """Tell every device that was used to go into its safe state; say which did not confirm."""
    safe_states = {role.device: role.contract.safe_state for role in run.roles.values()}
    for device in sorted(dispatcher.used):
        if not safe_states.get(device):
            continue
        try:
            confirmed, message = (await clients[device].stop(device)).get(
                device, (False, "no answer")
            )
        except (ServerUnreachable, OSError, TimeoutError) as fault:
            confirmed, message = False, str(fault)
        if not confirmed:
            run.log(f"{device} did not confirm its safe state: {message}. Go and look.")
        run.tell("safe", device, "confirmed" if confirmed else "unconfirmed", message)
        n = run.record(j.SafeState(device=device, confirmed=confirmed, message=message))
        run.history.touch(device, n)
    try:
        run.journal.flush()
    except (DiskFull, JournalFault) as fault:
        run.log(str(fault))


async def settle(run: Run, dispatcher: Dispatcher, control: Control) -> None:
    """Learn the fate of goals that were in flight when the engine went, before anything moves.

    Servers are asked what became of them; none is sent. Where nobody knows of a `once` action, its
    probe is sent now: after anything else was done, what it tells would prove nothing any more.
    """
    for past, outcome in await _carry(run, dispatcher, control, run.history.open_goals()):
        if outcome.state == "LOST":
            continue
        past.ended = j.GoalEnded(
            id=past.sent.id, state=outcome.state, result=outcome.result, error=outcome.error
        )
        past.ended_n = past.sent.n
        past.spent = run.history.lost_with_an_engine(past)
    unknown = [_probe_of(run, past) for past in run.history.unknown_fates()]
    probes = [probe for probe in unknown if probe is not None]
    await _carry(run, dispatcher, control, [], probes)
    for probe in probes:
        keep_answer(run.history, probe)


async def _carry(
    run: Run, dispatcher: Dispatcher, control: Control, pasts: list[PastGoal],
    new: list[Request] | None = None,
) -> list[tuple[PastGoal, Outcome]]:  # fmt: skip
    """Have goals adopted, and new ones done, all before this returns; what became of the adopted."""
    adopted = [(past, _adopt(run, past)) for past in pasts]
    requests = [request for _, request in adopted] + (new or [])
    for request in requests:
        dispatcher.request(request)
    while any(request.outcome is None for request in requests) and not control.now:
        ready = dispatcher.prepare()
        run.journal.flush()
        dispatcher.send(ready)
        if not dispatcher.busy:
            break
        if control.aborted_by:
            dispatcher.withdraw_all()
        dispatcher.check_time()
        await dispatcher.drain(STEP_S, stop=lambda: control.now)
    return [(past, request.outcome) for past, request in adopted if request.outcome is not None]


def _probe_of(run: Run, past: PastGoal) -> Request | None:
    role = next((r for r in run.roles.values() if r.device == past.sent.device), None)
    if role is None or past.sent.action not in role.contract.actions:
        return None
    error = past.ended.error if past.ended is not None else None
    known = error is not None and role.contract.actions[past.sent.action].happened(error.name)
    settled = told_before(run.history, past.sent.id) is not None
    if known in ("no", "yes") or settled or unknown_path(past.sent.id) in run.history.answers:
        return None
    return probe_request(run.history, role, past.sent.id, past.sent.action)


def strangers(run: Run, clients: Mapping[str, Reached]) -> set[str]:
    """Devices that somebody else has held or stopped since this run's last lease on them."""
    history = run.history
    return {d for d, c in clients.items() if history.somebody_was_there(d, c.epoch(d))}


def note_touched(
    run: Run, clients: Mapping[str, Reached], away_s: float, by_strangers: set[str]
) -> None:
    """Mark the devices whose state may have changed while the engine was away.

    Their servers were started anew, or put them into their safe state when the lease lapsed, or
    somebody else has used them.
    """
    for device, boot in run.history.boots.items():
        client = clients.get(device)
        if client is None:
            continue
        if client.boot != boot:
            touched(run, device, RESTARTED)
        elif device in by_strangers:
            touched(run, device, STRANGER)
        elif not 0 <= away_s <= LEASE_S:
            # A clock that was set back says nothing about how long it was: it may have been long.
            touched(run, device, LAPSED)


def touched(run: Run, device: str, reason: str) -> None:
    """Note that what finished steps had set on a device may be gone."""
    run.history.touch(device, run.record(j.Touched(device=device, reason=reason)))


def _adopt(run: Run, past: PastGoal) -> Request:
    sent = past.sent
    role = next(role for role in run.roles.values() if role.device == sent.device)
    path = sent.id.partition("/")[2].rpartition("/")[0]
    return Request(
        goal_id=sent.id, path=path, role=role, action_name=sent.action,
        action=role.contract.actions[sent.action], params=sent.params, timeout_s=sent.timeout_s,
        adopt=past,
    )  # fmt: skip
