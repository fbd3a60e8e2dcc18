"""One manual action: checked, leased, sent once under an id from its key, and followed to its end."""

import asyncio
import contextlib
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Any

from ...drivers.client.client import DeviceClient, LeaseHeld, Outcome, ServerUnreachable
from ...engine.language.arguments import ArgumentFaults, resolve_arguments
from ...engine.run.files import read_content, write_content
from ...engine.run.names import FileFault, inside
from ...schemas import messages
from ...schemas.contract import Action
from ...schemas.messages import Goal, GoalReport
from ...system.tasks import end, first_of, spawn
from ..access.headers import Deadline
from ..local.clock import now_iso
from ..local.refusal import Refusal, not_found
from ..models.devices import CallAction, GoalError, GoalState
from .arming import Arming
from .device_link import DeviceLink
from .form import level_of
from .step_text import step_text

ANSWER_S = 2.0
LEASE_S = 5.0
PATIENCE = 10.0
"""An action may take ten times as long as its contract states, and at least what the bench's settings say."""
ENDING_S = 120.0
"""How a cancelled action ended is awaited at least so long; the contract says when its server ends it."""
KEPT = 500


class Acting:
    """Manual actions, under way and recently ended; `changed` gets a goal's id."""

    def __init__(
        self, device_link: Callable[[str], DeviceLink], arming: Arming, folder: Path,
        changed: Callable[[str], None], moved: Callable[[str], None],
        least_s: Callable[[], float],
    ) -> None:  # fmt: skip
        self._device_link = device_link
        self._arming = arming
        self._folder = folder
        self._changed = changed
        self._moved = moved
        self._least_s = least_s
        self._goals: dict[str, GoalState] = {}
        self._tasks: set[asyncio.Task[None]] = set()

    async def close(self) -> None:
        """Cancel all tasks; a device finishes its action by itself."""
        await end(*self._tasks)

    def newest(self) -> list[str]:
        """The ids of those under way, and of those that ended last."""
        return list(self._goals)[-20:]

    def goal(self, id: str) -> GoalState:
        """One of them; raises Refusal (404)."""
        if id not in self._goals:
            raise not_found("action by hand", id, "they are forgotten when the server stops")
        return self._goals[id]

    def known(self, id: str) -> GoalState | None:
        """One of them, or None."""
        return self._goals.get(id)

    async def call(
        self, device: str, action: str, asked: CallAction, by: str, key: str, deadline: Deadline
    ) -> GoalState:
        """Do an action; returns when it has ended, or after two seconds."""
        device_link = self._device_link(device)
        wanted = device_link.contract.actions.get(action)
        if wanted is None:
            known = ", ".join(device_link.contract.actions)
            raise not_found("action", f"{device}.{action}", f"its actions are {known}")
        params = self.checked(device_link, action, asked.params)
        self._arming.check_free(device)
        device_link.reachable_client()
        if not wanted.meanwhile:
            device_link.check_turn()
        if level_of(wanted) == 3:
            self._arming.spend(device_link, action, by, asked.armed)
        return await self.do(device_link, action, params, by, key, deadline)

    def checked(
        self, device_link: DeviceLink, action: str, given: dict[str, Any]
    ) -> dict[str, Any]:
        """The parameters as the driver gets them; raises Refusal (422) with a problem for each."""
        label = f"{device_link.name}.{action}"
        wanted = device_link.contract.actions[action]
        try:
            params = resolve_arguments(wanted, given, device_link.device.limits, label=label)
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
        self, device_link: DeviceLink, action: str, params: dict[str, Any], by: str, key: str,
        deadline: Deadline,
    ) -> GoalState:  # fmt: skip
        """Send a checked action; returns when it has ended, or after two seconds."""
        id = f"web-{sha256(key.encode()).hexdigest()[:20]}"
        state = GoalState(
            id=id, device=device_link.name, action=action, params=params, state="ACCEPTED", by=by,
            began_at=now_iso(), step=step_text(device_link.name, action, params),
        )  # fmt: skip
        leased: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        if device_link.goal is not None and device_link.contract.actions[action].meanwhile:
            work = self._send(device_link, state, deadline, leased)  # by the lease that is held
        else:
            await device_link.take_turn()
            work = self._carry(device_link, state, deadline, leased)
        name = f"{device_link.name}.{action} by hand"
        task = spawn(name, work, expected=(Refusal,), among=self._tasks)
        await first_of((task, leased))
        if not leased.done():
            task.result()  # a refusal before anything was sent
        await asyncio.wait({task}, timeout=ANSWER_S)
        return self._goals[id]

    async def cancel(self, id: str) -> GoalState:
        """Request the end of an action; no effect on one that has ended."""
        state = self.goal(id)
        if state.ended_at is not None:
            return state
        device_link = self._device_link(state.device)
        if not device_link.contract.actions[state.action].cancel:
            raise Refusal(
                409, "NO_CANCEL", f"{state.device}.{state.action} cannot be cancelled",
                "it ends by itself; STOP ALL interrupts it",
            )  # fmt: skip
        try:
            await device_link.reachable_client().cancel(id)
        except ServerUnreachable as fault:
            raise Refusal(503, "LOST", str(fault)) from fault
        return self._goals[id]

    def file(self, id: str, name: str) -> Path:
        """A file that an action delivered."""
        state = self.goal(id)
        if name not in state.files:
            raise not_found("file", name)
        return inside(self._folder / id, name)

    async def _carry(
        self,
        device_link: DeviceLink,
        state: GoalState,
        deadline: Deadline,
        leased: asyncio.Future[None],
    ) -> None:
        """From the lease to the outcome; nothing is sent before `leased` is set."""
        try:
            client = device_link.reachable_client()
            await take_lease(client, device_link.name, state.by)
            device_link.goal = state.id
            try:
                await self._send(device_link, state, deadline, leased)
            finally:
                device_link.leave_turn()
                await client.release(device_link.name)
                self._changed(state.id)
                self._moved(device_link.name)
        finally:
            device_link.end_turn()

    async def _send(
        self,
        device_link: DeviceLink,
        state: GoalState,
        deadline: Deadline,
        leased: asyncio.Future[None],
    ) -> None:
        deadline.check()
        client = device_link.reachable_client()
        goal = self._goal(device_link, client, state)
        self._goals[state.id] = state
        self._forget_old()
        self._note(state)
        leased.set_result(None)
        action = device_link.contract.actions[state.action]
        try:
            outcome = await follow(
                client, goal, action, lambda r: self._report(state.id, r), self._least_s()
            )
            device_link.take_result(outcome.result)
            for content in outcome.files.values():
                await asyncio.to_thread(write_content, self._folder / state.id, content)
        except Exception as fault:  # the goal must not stay under way; the log has the traceback
            words = f"{state.device}.{state.action} is no longer followed: {fault}"
            self._end(state.id, lost(type(fault).__name__, words))
            raise
        self._end(state.id, outcome)

    def _goal(self, device_link: DeviceLink, client: DeviceClient, state: GoalState) -> Goal:
        action = device_link.contract.actions[state.action]
        read, _ = action.path_params()
        try:
            files = {
                n: read_content(self._folder, state.params[n]) for n in read if n in state.params
            }
        except FileFault as fault:
            raise Refusal(422, "PARAMS", str(fault)) from fault
        return Goal(
            id=state.id, device=device_link.name, boot=client.boot, epoch=client.epoch(device_link.name),
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
        told: dict[str, Any] = {
            "state": outcome.state, "result": outcome.result, "ended_at": now_iso(),
            "files": [content.path for content in outcome.files.values()],
            "error": None if error is None else GoalError.of(error),
        }  # fmt: skip
        self._goals[id] = self._goals[id].model_copy(update=told)
        self._changed(id)

    def _note(self, state: GoalState) -> None:
        self._goals[state.id] = state
        self._changed(state.id)
        self._moved(state.device)

    def _forget_old(self) -> None:
        over = [id for id, state in self._goals.items() if state.ended_at is not None]
        for id in over[: max(0, len(over) - KEPT)]:
            del self._goals[id]


async def take_lease(client: DeviceClient, device: str, by: str, ttl_s: float = LEASE_S) -> None:
    """Hold a device for a manual action; raises Refusal if it is held already."""
    try:
        await client.take_lease(device, f"web: {by}", ttl_s)
    except LeaseHeld as fault:
        raise Refusal(
            409,
            "HELD",
            f"{device} is held by {fault.holder}",
            "wait until that has ended, or end it",
        ) from fault
    except ServerUnreachable as fault:
        raise Refusal(503, "LOST", str(fault)) from fault


async def follow(
    client: DeviceClient, goal: Goal, action: Action, report: Callable[[GoalReport], None],
    least_s: float,
) -> Outcome:  # fmt: skip
    """Follow a goal to its end; one that takes far too long is cancelled, then awaited."""
    typical_s = action.typical_s(goal.params) or 0.0
    following = spawn(f"follow {goal.id}", client.follow(goal, report))
    try:
        await asyncio.wait({following}, timeout=max(least_s, PATIENCE * typical_s))
        if not following.done() and action.cancel:
            with contextlib.suppress(ServerUnreachable):
                await client.cancel(goal.id)
            await asyncio.wait({following}, timeout=max(least_s, ENDING_S))
        if not following.done():
            words = f"{goal.device}.{goal.action} did not end and is no longer followed"
            words += " (Settings says how long it may take)"
            return lost("Timeout", words)
        return following.result()
    finally:
        await end(following)


def lost(name: str, message: str) -> Outcome:
    """The outcome of a goal of which nothing more is known."""
    return Outcome("LOST", error=messages.GoalError(name=name, message=message, happened="unknown"))
