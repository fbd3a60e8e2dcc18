"""One action by hand: checked, leased, sent once under an id of its key, and followed to its end."""

import asyncio
import contextlib
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Any

from ...drivers.client import DeviceClient, LeaseHeld, Outcome, ServerUnreachable
from ...engine.language.arguments import ArgumentFaults, resolve_arguments
from ...engine.run_files import FileFault, inside, read_content, write_content
from ...schemas.contract import Action
from ...schemas.messages import Goal, GoalReport
from ...schemas.quantity import seconds
from ..clock import now_iso
from ..guard.headers import Deadline
from ..guard.refusal import Refusal, not_found
from ..models.devices import CallAction, GoalError, GoalState
from .arming import Arming
from .form import level_of
from .station import Station
from .step_text import step_text

ANSWER_S = 2.0
LEASE_S = 5.0
LEAST_S, PATIENCE = 120.0, 10.0
"""An action may take ten times what its contract says, and two minutes at least."""
KEPT = 500


class Acting:
    """Actions by hand, those under way and the last that are over; `changed` gets a goal's id."""

    def __init__(
        self, station: Callable[[str], Station], arming: Arming, folder: Path,
        changed: Callable[[str], None], moved: Callable[[str], None],
    ) -> None:  # fmt: skip
        self._station = station
        self._arming = arming
        self._folder = folder
        self._changed = changed
        self._moved = moved
        self._goals: dict[str, GoalState] = {}
        self._tasks: dict[str, asyncio.Task[None]] = {}

    async def close(self) -> None:
        """Leave no task; what a device does it brings to its end by itself."""
        tasks = list(self._tasks.values())
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    def goals(self) -> dict[str, GoalState]:
        """Those under way, and those that ended last."""
        return dict(list(self._goals.items())[-20:])

    def goal(self, id: str) -> GoalState:
        """One of them; raises Refusal (404)."""
        if id not in self._goals:
            raise not_found("action by hand", id, "they are forgotten when the server ends")
        return self._goals[id]

    def known(self, id: str) -> GoalState | None:
        """One of them, or None."""
        return self._goals.get(id)

    async def call(
        self, device: str, action: str, asked: CallAction, by: str, key: str, deadline: Deadline
    ) -> GoalState:
        """Do an action; returns when it is over, or after two seconds."""
        station = self._station(device)
        wanted = station.contract.actions.get(action)
        if wanted is None:
            known = ", ".join(station.contract.actions)
            raise not_found("action", f"{device}.{action}", f"it has {known}")
        params = self.checked(station, action, asked.params)
        self._arming.check_free(device)
        station.reached()
        if station.turn.locked() and not wanted.meanwhile:
            raise Refusal(409, "BUSY", f"{device} is busy with another action by hand")
        if level_of(wanted) == 3:
            self._arming.spend(station, action, by, asked.armed)
        return await self.do(station, action, params, by, key, deadline)

    def checked(self, station: Station, action: str, given: dict[str, Any]) -> dict[str, Any]:
        """The parameters as the driver gets them; raises Refusal (422) with one word for each."""
        label = f"{station.name}.{action}"
        wanted = station.contract.actions[action]
        try:
            params = resolve_arguments(wanted, given, station.device.limits, label=label)
            read, written = wanted.path_params()
            for name in (*read, *written):
                if name in params:
                    inside(self._folder, str(params[name]))
        except ArgumentFaults as faults:
            told = {fault.param: fault.message for fault in faults.faults}
            raise Refusal(422, "PARAMS", str(faults), details={"params": told}) from faults
        except FileFault as fault:
            raise Refusal(422, "PARAMS", str(fault)) from fault
        return params

    async def do(
        self, station: Station, action: str, params: dict[str, Any], by: str, key: str,
        deadline: Deadline,
    ) -> GoalState:  # fmt: skip
        """Send a checked action; returns when it is over, or after two seconds."""
        id = f"web-{sha256(key.encode()).hexdigest()[:20]}"
        state = GoalState(
            id=id, device=station.name, action=action, params=params, state="ACCEPTED", by=by,
            began_at=now_iso(), step=step_text(station.name, action, params),
        )  # fmt: skip
        leased: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        task = asyncio.create_task(self._carry(station, state, deadline, leased))
        self._tasks[id] = task
        task.add_done_callback(lambda _: self._tasks.pop(id, None))
        try:
            await asyncio.wait({task, leased}, return_when=asyncio.FIRST_COMPLETED)
            if task.done() and not leased.done():
                task.result()  # a refusal before anything was sent
            await asyncio.wait({task}, timeout=ANSWER_S)
        finally:
            leased.cancel()
        return self._goals[id]

    async def cancel(self, id: str) -> GoalState:
        """Ask for the end of an action; one that is over stays as it was."""
        state = self.goal(id)
        if state.ended_at is not None:
            return state
        station = self._station(state.device)
        if not station.contract.actions[state.action].cancel:
            raise Refusal(
                409, "NO_CANCEL", f"{state.device}.{state.action} cannot be cancelled",
                "it ends by itself; STOP ALL breaks it off",
            )  # fmt: skip
        try:
            await station.reached().cancel(id)
        except ServerUnreachable as fault:
            raise Refusal(503, "LOST", str(fault)) from fault
        return self._goals[id]

    def file(self, id: str, name: str) -> Path:
        """A file that an action gave."""
        state = self.goal(id)
        if name not in state.files:
            raise not_found("file", name)
        return inside(self._folder / id, name)

    async def _carry(
        self, station: Station, state: GoalState, deadline: Deadline, leased: asyncio.Future[None]
    ) -> None:
        """From the lease to the last word; before `leased` is set, nothing was sent."""
        if station.contract.actions[state.action].meanwhile and station.turn.locked():
            return await self._send(station, state, deadline, leased)  # by the lease that is held
        async with station.turn:
            client = station.reached()
            await take_lease(client, station.name, state.by)
            station.goal = state.id
            try:
                await self._send(station, state, deadline, leased)
            finally:
                station.goal = None
                await client.release(station.name)
                self._changed(state.id)
                self._moved(station.name)

    async def _send(
        self, station: Station, state: GoalState, deadline: Deadline, leased: asyncio.Future[None]
    ) -> None:
        deadline.check()
        client = station.reached()
        goal = self._goal(station, client, state)
        self._goals[state.id] = state
        self._forget_old()
        self._note(state)
        if not leased.done():
            leased.set_result(None)
        action = station.contract.actions[state.action]
        outcome = await follow(client, goal, action, lambda r: self._report(state.id, r))
        station.take_result(outcome.result)
        await asyncio.to_thread(self._end, state.id, outcome)
        self._changed(state.id)

    def _goal(self, station: Station, client: DeviceClient, state: GoalState) -> Goal:
        action = station.contract.actions[state.action]
        read, _ = action.path_params()
        try:
            files = {
                n: read_content(self._folder, state.params[n]) for n in read if n in state.params
            }
        except FileFault as fault:
            raise Refusal(422, "PARAMS", str(fault)) from fault
        return Goal(
            id=state.id, device=station.name, boot=client.boot, epoch=client.epoch(station.name),
            action=state.action, params=state.params, files=files,
        )  # fmt: skip

    def _report(self, id: str, report: GoalReport) -> None:
        if not report.ended:
            before = self._goals[id]
            progress = report.progress if report.progress is not None else before.progress
            told = {
                "state": report.state,
                "progress": progress,
                "message": report.message or before.message,
            }
            self._note(before.model_copy(update=told))

    def _end(self, id: str, outcome: Outcome) -> None:
        error = outcome.error
        for content in outcome.files.values():
            write_content(self._folder / id, content)
        told: dict[str, Any] = {
            "state": outcome.state, "result": outcome.result, "ended_at": now_iso(),
            "files": [content.path for content in outcome.files.values()],
            "error": None if error is None else GoalError(
                name=error.name, message=error.message, happened=error.happened
            ),
        }  # fmt: skip
        self._goals[id] = self._goals[id].model_copy(update=told)

    def _note(self, state: GoalState) -> None:
        self._goals[state.id] = state
        self._changed(state.id)
        self._moved(state.device)

    def _forget_old(self) -> None:
        over = [id for id, state in self._goals.items() if state.ended_at is not None]
        for id in over[: max(0, len(over) - KEPT)]:
            del self._goals[id]


async def take_lease(client: DeviceClient, device: str, by: str, ttl_s: float = LEASE_S) -> None:
    """Hold a device for an action by hand; raises Refusal where somebody else has it."""
    try:
        await client.take_lease(device, f"web: {by}", ttl_s)
    except LeaseHeld as fault:
        raise Refusal(
            409, "HELD", f"{device} is held by {fault.holder}", "wait until that is over, or end it"
        ) from fault
    except ServerUnreachable as fault:
        raise Refusal(503, "LOST", str(fault)) from fault


async def follow(
    client: DeviceClient, goal: Goal, action: Action, report: Callable[[GoalReport], None]
) -> Outcome:
    """Follow a goal to its end; one that takes far too long is cancelled and waited for."""
    typical_s = seconds(action.duration) if action.duration is not None else 0.0
    following = asyncio.create_task(client.follow(goal, report))
    try:
        done, _ = await asyncio.wait({following}, timeout=max(LEAST_S, PATIENCE * typical_s))
        if not done and action.cancel:
            with contextlib.suppress(ServerUnreachable):
                await client.cancel(goal.id)
            await asyncio.wait({following}, timeout=LEAST_S)
        if not following.done():
            return Outcome("LOST", error=_silent(goal))
        return following.result()
    finally:
        following.cancel()
        await asyncio.gather(following, return_exceptions=True)


def _silent(goal: Goal) -> Any:
    from ...schemas.messages import GoalError as Error

    message = f"{goal.device}.{goal.action} did not end; nobody waits for it any more"
    return Error(name="Timeout", message=message, happened="unknown")
