"""Actions and services of a ROS 2 robot as those of a contract, so that protocols can use it.

Configuration: see `config.py`. What a failed goal says becomes an error of the contract: see
`answers.py`.
"""

import asyncio
import contextlib
import copy
import functools
import re
import time
from typing import Any, ClassVar
from uuid import uuid4

from ...system.tasks import end, first_of, in_time, spawn
from ..driver import ActionCanceled, ActionFailed, Driver, GoalContext, Place
from .bridge import ABORTED, CANCELED, SUCCEEDED, Bridge, Gone, Rejected, Sent, Values
from .config import Config, RosGoal, RosStatus, read_config
from .field_path import gap
from .own_goals import OwnGoals

SAFE_S = 8.0
STATUS_S = 1.5
LOOK_S = 0.5
"""How often it is looked whether the robot of a goal is still there."""


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
        self._own = OwnGoals(place.folder)
        self._sent: dict[asyncio.Future[tuple[int, Values]], Sent] = {}
        self._status: Values = {}
        self._heard_at: dict[str, float] = {}
        self._told = asyncio.Event()
        for name in place.contract.actions:
            setattr(self, name, functools.partial(self._do, name))

    async def open(self) -> None:
        await self._bridge.open()
        for topic in self._config.status:
            hear = functools.partial(self._heard, topic)
            self._bridge.listen(topic.topic, topic.type, hear, topic.qos)
            self._heard_at[topic.topic] = time.monotonic()

    async def close(self) -> None:
        await self._bridge.close()

    async def status(self) -> Values:
        """The topics' last messages, as the contract's status."""
        if not self._bridge.connected:
            raise Gone(f"{self.place.device}: the connection to ROS is broken; reconnecting")
        silent = self._silent()
        if silent:
            raise Gone(f"{self.place.device}: {silent}")
        return dict(self._status)

    async def safe(self) -> None:
        """Cancel what this driver has under way, wait for its end, go to the contract's safe state.

        Also what an earlier session left behind, and what was lost from sight; where the connection
        could not choose the id of such a goal, every goal of its action is cancelled. Goals of others
        go on.
        """
        for id, name in list(self._own.left.items()):
            ros = self._config.actions.get(name)
            if ros is not None and not ros.is_service:
                await self._bridge.cancel_left(ros.action, id)
            self._own.end(id)
        for sent in list(self._sent.values()):
            sent.cancel()
        running = set(self._sent)
        if running:
            _, left = await asyncio.wait(running, timeout=SAFE_S)
            if left:
                raise Gone(f"{len(left)} goals did not end within {SAFE_S:g} s of being cancelled")
        for action in self.contract_kept.safe_state:
            await self._do(action, GoalContext(f"safe:{action}"))
        if self._config.status:  # its current value is outdated
            self._told.clear()
            await in_time(self._told.wait(), STATUS_S)

    async def _do(self, name: str, goal: GoalContext, **params: Any) -> Values:
        ros = self._config.actions[name]
        message = _message(ros, params)
        if ros.is_service:
            return self._returned(ros, await self._called(ros, message))
        id = uuid4().bytes
        self._own.begin(id, name)
        try:
            sent = await self._bridge.send(
                ros.action, ros.type, message, functools.partial(_tell, ros, goal), id
            )
            self._sent[sent.ended] = sent
            sent.ended.add_done_callback(self._over)
            status, result = await self._until_ended(ros, sent, goal)
            self._own.end(id)
        except Rejected as fault:
            self._own.end(id)
            raise ActionFailed("Rejected", f"{ros.action}: {fault}", "no") from fault
        except Gone as fault:
            raise ActionFailed("Lost", f"{ros.action}: {fault}", "unknown") from fault
        finally:
            self._own.lose(id)  # it may still be under way there
        if status == CANCELED and goal.cancelled.is_set():
            raise ActionCanceled
        if status == CANCELED:
            words = f"{ros.action} was cancelled by another client"
            raise ActionFailed("Stopped", words, "unknown")
        if status == ABORTED:
            raise self._failure(name, ros, result)
        if status != SUCCEEDED:  # as 0, where the server was started again, or has forgotten it
            words = (
                f"{ros.action} ended with the status {status}, which says nothing of what happened"
            )
            raise ActionFailed("Lost", words, "unknown")
        return self._returned(ros, result)

    async def _called(self, ros: RosGoal, message: Values) -> Values:
        try:
            async with asyncio.timeout(ros.answer_s):
                return await self._bridge.call(ros.action, ros.type, message)
        except Rejected as fault:
            raise ActionFailed("Rejected", f"{ros.action}: {fault}", "no") from fault
        except TimeoutError as fault:
            words = f"{ros.action} did not answer within {ros.answer_s:g} s (`answer_s`)"
            raise ActionFailed("Lost", words, "unknown") from fault
        except Gone as fault:
            raise ActionFailed("Lost", f"{ros.action}: {fault}", "unknown") from fault

    async def _until_ended(self, ros: RosGoal, sent: Sent, goal: GoalContext) -> tuple[int, Values]:
        cancelled = spawn(f"the cancel of {goal.id}", goal.cancelled.wait())
        gone = spawn(f"a watch on {ros.action}", self._until_gone(ros), expected=(Gone,))
        try:
            await first_of({sent.ended, gone, cancelled})
            if cancelled.done():
                sent.cancel()
                await first_of({sent.ended, gone})
            if not sent.ended.done():
                gone.result()
            return await asyncio.shield(sent.ended)
        finally:
            self._sent.pop(sent.ended, None)
            if not sent.ended.done() and self._bridge.connected:
                sent.cancel()  # nobody waits for it any more; a stop makes sure
            await end(cancelled, gone)

    async def _until_gone(self, ros: RosGoal) -> None:
        """Returns never; raises Gone once the robot of an action is no longer there."""
        missing_since: float | None = None
        while True:
            await asyncio.sleep(LOOK_S)
            silent = self._silent()
            if silent:
                raise Gone(silent)
            if await self._bridge.serves(ros.action, ros.type):
                missing_since = None
                continue
            missing_since = missing_since or time.monotonic()
            if time.monotonic() - missing_since >= self._config.gone_s:
                raise Gone("its action server is gone; the robot ended, or lost its network")

    def _silent(self) -> str:
        """Which topic has been silent for longer than it may; an empty string if none."""
        now = time.monotonic()
        for topic in self._config.status:
            silent_s = now - self._heard_at.get(topic.topic, now)
            if topic.silent_s is not None and silent_s > topic.silent_s:
                return f"nothing was heard on {topic.topic} for {silent_s:.1f} s; is the robot on?"
        return ""

    def _returned(self, ros: RosGoal, result: Values) -> Values:
        name = next(name for name, one in self._config.actions.items() if one is ros)
        if ros.failure.of(result) is not None:
            raise self._failure(name, ros, result)
        found = {name: spot.get(result) for name, spot in ros.result.items()}
        return {name: value for name, value in found.items() if value is not None}

    def _failure(self, name: str, ros: RosGoal, result: Values) -> ActionFailed:
        code, said = ros.failure.of(result) or ("", "")
        error = ros.failure.names.get(code, code if code in self._config.errors[name] else "")
        numbered = f"{ros.action} failed" + (f" with the code {code}" if code else "")
        plain = bool(error) or not re.fullmatch(r"-?\d+", code)  # a number says something by itself
        words = said if said and plain else f"{numbered}: {said}" if said else numbered
        happened: Any = result.get("error_happened")
        return ActionFailed(
            error or ros.aborted, words, happened if happened in ("no", "yes") else None
        )

    def _over(self, ended: "asyncio.Future[tuple[int, Values]]") -> None:
        self._sent.pop(ended, None)
        with contextlib.suppress(asyncio.CancelledError):
            ended.exception()  # raised where it is awaited; after a stop nothing may await it

    def _heard(self, topic: RosStatus, message: Values) -> None:
        told = {name: spot.get(message) for name, spot in topic.fields.items()}
        kept = {name: value for name, value in self._status.items() if name not in told}
        self._status = kept | {name: value for name, value in told.items() if value is not None}
        self._heard_at[topic.topic] = time.monotonic()
        self._told.set()


def _message(ros: RosGoal, params: dict[str, Any]) -> Values:
    message: Values = copy.deepcopy(ros.constants)
    for param, value in params.items():
        ros.goal[param].put(message, value)
    missing = gap(message)
    if missing is not None:
        words = f"{ros.action}: nothing was given for {missing}; give it, or set it in `constants`"
        raise ActionFailed("Rejected", words, "no")
    return message


def _tell(ros: RosGoal, goal: GoalContext, feedback: Values) -> None:
    goal.feedback(*ros.feedback.read(feedback))


def _bridge(config: Config) -> Bridge:
    if config.bridge is not None:
        from .by_rosbridge import RosbridgeWay

        return RosbridgeWay(config.bridge)
    from .by_rclpy import RclpyWay

    return RclpyWay()
