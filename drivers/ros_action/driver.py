"""Actions of a ROS 2 robot as those of a contract, so that protocols can use it.

Configuration: see `config.py`. A goal that ROS reports ABORTED fails with the contract's error
named by the result's `error_name`, else with the one named by `aborted`.
"""

import asyncio
import contextlib
import copy
import functools
import math
from typing import Any, ClassVar

from ...system.tasks import end, first_of, spawn
from ..driver import ActionCanceled, ActionFailed, Driver, GoalContext, Place
from .bridge import ABORTED, CANCELED, Bridge, Gone, Rejected, Sent, Values
from .config import Config, RosGoal, read_config

SAFE_S = 8.0
STATUS_S = 1.5


class RosAction(Driver):
    """Implements whichever contract its lab names; the actions are those of the configuration."""

    any_contract: ClassVar[bool] = True

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        if place.contract is None:
            raise ValueError("ros_action needs a contract")
        self.contract_kept = place.contract
        self._config = read_config(place.config, place.contract)
        self._bridge = _bridge(self._config)
        self._sent: dict[asyncio.Future[tuple[int, Values]], Sent] = {}
        self._status: Values = {}
        self._told = asyncio.Event()
        for name in place.contract.actions:
            setattr(self, name, functools.partial(self._do, name))

    async def open(self) -> None:
        await self._bridge.open()
        if self._config.status is not None:
            self._bridge.listen(self._config.status.topic, self._config.status.type, self._heard)

    async def close(self) -> None:
        await self._bridge.close()

    async def status(self) -> Values:
        """The topic's last message, as the contract's status."""
        if not self._bridge.connected:
            raise Gone(f"{self.place.device}: the connection to ROS is broken; reconnecting")
        return dict(self._status)

    async def safe(self) -> None:
        """Cancel what runs and wait for its end; then go to the contract's safe state.

        Every goal of these actions is cancelled, whoever sent it: after a restart the ids of goals
        that an earlier session of the driver left behind are unknown.
        """
        for name, ros in self._config.actions.items():
            if name not in self.contract_kept.safe_state:
                self._bridge.cancel_all(ros.action)
        for sent in list(self._sent.values()):
            sent.cancel()
        running = set(self._sent)
        if running:
            _, left = await asyncio.wait(running, timeout=SAFE_S)
            if left:
                raise Gone(f"{len(left)} goals did not end within {SAFE_S:g} s of being cancelled")
        for action in self.contract_kept.safe_state:
            await self._do(action, GoalContext(f"safe:{action}"))
        if self._config.status is not None:  # its current value is outdated
            self._told.clear()
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(STATUS_S):
                    await self._told.wait()

    async def _do(self, name: str, goal: GoalContext, **params: Any) -> Values:
        ros = self._config.actions[name]
        message: Values = copy.deepcopy(ros.constants)
        for param, value in params.items():
            ros.goal[param].put(message, value)
        try:
            sent = self._bridge.send(ros.action, ros.type, message, functools.partial(_tell, goal))
        except (Rejected, Gone) as fault:
            raise ActionFailed("Rejected", f"{ros.action}: {fault}", "no") from fault
        self._sent[sent.ended] = sent
        sent.ended.add_done_callback(self._over)
        try:
            status, result = await self._until_ended(sent, goal)
        except Rejected as fault:
            raise ActionFailed("Rejected", f"{ros.action}: {fault}", "no") from fault
        except Gone as fault:
            raise ActionFailed("Lost", f"{ros.action}: {fault}", "unknown") from fault
        if status == CANCELED and goal.cancelled.is_set():
            raise ActionCanceled
        if status in (CANCELED, ABORTED):
            raise self._failure(name, ros, status, result)
        return _returned(ros, result)

    async def _until_ended(self, sent: Sent, goal: GoalContext) -> tuple[int, Values]:
        cancelled = spawn(f"the cancel of {goal.id}", goal.cancelled.wait())
        try:
            await first_of({sent.ended, cancelled})
            if not sent.ended.done():
                sent.cancel()
            return await asyncio.shield(sent.ended)
        finally:
            await end(cancelled)

    def _failure(self, name: str, ros: RosGoal, status: int, result: Values) -> ActionFailed:
        said = str(result.get("error_name", ""))
        words = str(result.get("error_message", "")) or f"{ros.action} ended with status {status}"
        happened: Any = result.get("error_happened")
        if status == CANCELED:
            return ActionFailed(
                "Stopped", f"{ros.action} was cancelled by another client", "unknown"
            )
        known = said in self._config.errors[name]
        return ActionFailed(
            said if known else ros.aborted, words, happened if happened in ("no", "yes") else None
        )

    def _over(self, ended: "asyncio.Future[tuple[int, Values]]") -> None:
        self._sent.pop(ended, None)
        with contextlib.suppress(asyncio.CancelledError):
            ended.exception()  # raised where it is awaited; after a stop nothing may await it

    def _heard(self, message: Values) -> None:
        assert self._config.status is not None
        told = {name: spot.get(message) for name, spot in self._config.status.fields.items()}
        self._status = {name: value for name, value in told.items() if value is not None}
        self._told.set()


def _tell(goal: GoalContext, feedback: Values) -> None:
    progress = feedback.get("progress")
    known = isinstance(progress, (int, float)) and math.isfinite(progress)
    words = feedback.get("message", feedback.get("msg", feedback.get("feedback", "")))
    told = float(progress) if known and progress is not None else None
    goal.feedback(told, words if isinstance(words, str) else "")


def _returned(ros: RosGoal, result: Values) -> Values:
    found = {name: spot.get(result) for name, spot in ros.result.items()}
    return {name: value for name, value in found.items() if value is not None}


def _bridge(config: Config) -> Bridge:
    if config.bridge is not None:
        from .by_rosbridge import RosbridgeWay

        return RosbridgeWay(config.bridge)
    from .by_rclpy import RclpyWay

    return RclpyWay()
