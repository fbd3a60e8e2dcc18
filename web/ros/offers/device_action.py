"""An action of a device as a ROS action: checked, leased, sent once, and followed to its end."""

import asyncio
import contextlib
from pathlib import Path
from typing import Any

from ....drivers.client.client import DeviceClient, Outcome, ServerUnreachable
from ....engine.language.arguments import ArgumentFaults, resolve_arguments
from ....engine.run.files import read_content, write_content
from ....engine.run.names import FileFault, inside
from ....schemas.messages import Goal, GoalReport
from ....system.tasks import end, first_of, spawn
from ..interfaces.kinds import ActionKind
from ..interfaces.values import ValueFault, from_ros
from .device import Device
from .goals import aborted, result_of
from .offer import Action, End, Refused, Values, Work

PATIENCE = 10.0
"""An action may take ten times as long as its contract states, and at least the lab's `action_timeout`."""


class DeviceAction(Action):
    """`folder`: the files that an action reads or writes."""

    def __init__(
        self, name: str, kind: ActionKind, device: Device, action: str, folder: Path
    ) -> None:
        self.name = name
        self.kind = kind
        self.device = device
        self.action = action
        self.wanted = device.contract.actions[action]
        self.can_cancel = self.wanted.cancel
        self._folder = folder
        typical_s = self.wanted.typical_s({}) or 0.0
        self._patience_s = max(device.action_timeout_s, PATIENCE * typical_s)

    async def carry(self, work: Work) -> End:
        """One ROS goal is one goal of the device."""
        params = self.checked(self._params(work.values))
        return self.ending(await self.sent(params, work), work)

    def _params(self, values: Values) -> dict[str, Any]:
        try:
            return from_ros(self.kind.goal, values)
        except ValueFault as fault:
            raise Refused(str(fault)) from fault

    def checked(self, params: dict[str, Any]) -> dict[str, Any]:
        """Parameters as the driver gets them; raises Refused with all problems."""
        label, limits = f"{self.device.name}.{self.action}", self.device.device.limits
        try:
            fitted = resolve_arguments(self.wanted, params, limits, label=label)
            read, written = self.wanted.path_params()
            for name in (*read, *written):
                if name in fitted:
                    inside(self._folder, str(fitted[name]))
        except (ArgumentFaults, FileFault) as fault:
            raise Refused(str(fault)) from fault
        return fitted

    async def sent(self, params: dict[str, Any], work: Work, part: int = 1) -> Outcome:
        """Send checked parameters and wait; `part` counts if one ROS goal needs several."""
        async with self.device.borrowed() as client:
            goal = self._goal(client, params, f"{self.device.owner}/{work.id}/{part}")

            said: list[tuple[float | None, str]] = [(None, "")]

            def report(hear: GoalReport) -> None:
                work.begun.set()
                new = (hear.progress, hear.message)
                if hear.state == "EXECUTING" and new != said[-1]:  # heartbeats repeat it
                    said[:] = [new]
                    work.tell(feedback(*new))

            return await self._followed(client, goal, work, report)

    def _goal(self, client: DeviceClient, params: dict[str, Any], id: str) -> Goal:
        read, _ = self.wanted.path_params()
        try:
            files = {n: read_content(self._folder, params[n]) for n in read if n in params}
        except FileFault as fault:
            raise Refused(str(fault)) from fault
        return Goal(
            id=id, device=self.device.name, boot=client.boot,
            epoch=client.epoch(self.device.name), action=self.action, params=params, files=files,
        )  # fmt: skip

    async def _followed(self, client: DeviceClient, goal: Goal, work: Work, report: Any) -> Outcome:
        following = spawn(f"following {goal.id}", client.follow(goal, report))
        lost = spawn(f"the loss of {self.device.name}", self.device.lost.wait())
        canceled = spawn(f"the cancel of {goal.id}", work.cancelled.wait())
        until = asyncio.get_running_loop().time() + self._patience_s
        waiting: set[asyncio.Task[Any]] = {following, lost, canceled}
        try:
            while not following.done():
                left_s = until - asyncio.get_running_loop().time()
                await first_of(waiting, max(left_s, 0))
                if canceled in waiting and canceled.done():
                    waiting.discard(canceled)
                    with contextlib.suppress(ServerUnreachable):
                        await client.cancel(goal.id)
                elif not following.done():
                    words = f"the server of {self.device.name} is gone: {self.device.reason}"
                    late = (
                        f"{self.name} did not end within {self._patience_s:g} s; `ros: action_timeout` of "
                        "the lab, or the action's `duration` in its contract, gives it longer"
                    )
                    gone = lost.done()
                    return _given_up("Lost" if gone else "Timeout", words if gone else late)
            return following.result()
        finally:
            await end(lost, canceled)
            if not following.done():
                self.device.bring_to_end(goal.id, following)

    def ending(self, outcome: Outcome, work: Work) -> End:
        """The end of the ROS goal for a device's outcome."""
        error = outcome.error
        if outcome.state == "SUCCEEDED":
            try:
                for content in outcome.files.values():
                    write_content(self._folder, content)
            except (FileFault, OSError) as fault:
                words = f"it was done, but its file could not be stored: {fault}"
                return aborted(self, "DiskFull", words, "yes", **(outcome.result or {}))
            return End("SUCCEEDED", result_of(self, outcome.result or {}))
        if error is not None and error.name in ("Busy", "Rejected") and not work.begun.is_set():
            raise Refused(f"{self.device.name}.{self.action}: {error.message}")
        work.begun.set()
        if outcome.state == "CANCELED" and work.cancelled.is_set():
            return End("CANCELED", result_of(self, outcome.result or {}, "Canceled", "as asked"))
        if outcome.state == "CANCELED":  # not by a ROS client: CANCELED would be wrong for them
            return aborted(self, "Stopped", f"somebody stopped {self.device.name}", "unknown")
        name, words = (error.name, error.message) if error else ("Lost", "its outcome is unknown")
        happened = error.happened if error is not None else "unknown"
        return aborted(self, name, words, happened, **(outcome.result or {}))


def _given_up(name: str, message: str) -> Outcome:
    from ....schemas.messages import GoalError

    return Outcome("ABORTED", error=GoalError(name=name, message=message, happened="unknown"))


def feedback(progress: float | None, message: str) -> Values:
    """The feedback of a device's action."""
    return {"progress": float("nan") if progress is None else progress, "message": message}
