"""Through a rosbridge, with roslibpy; it reconnects by itself."""

import asyncio
import logging
from collections.abc import Callable
from typing import Any
from uuid import uuid4

from ...system.extras import not_installed
from .bridge import Bridge, Gone, Rejected, Sent, Values, resolve

OPEN_S = 5.0
LOOK_S = 2.0
"""How often a robot is asked whether its action server is there."""
CANCEL_AGAIN_S = (0.5, 1.0, 2.0, 4.0)
"""When a cancel is sent again: rosbridge_suite before 2026 loses one that precedes the acceptance."""
CANCEL = "action_msgs/srv/CancelGoal"
LOG = logging.getLogger("labrun")


class RosbridgeWay(Bridge):
    """`url`: `ws://HOST:PORT`, with `/?token=...` if the bridge requires one.

    Each goal and each call under way has a connection of its own: rosbridge_suite up to 2.1, as started
    by default, hears nothing on it until that has ended, no cancel either, and nothing ever again once
    a server has rejected a goal.
    """

    def __init__(self, url: str) -> None:
        try:
            import roslibpy
        except ImportError as fault:
            raise ValueError(not_installed(fault) or str(fault)) from fault
        self._roslibpy: Any = roslibpy
        self._url = url
        self._all: list[Any] = []
        self._ros: Any = None
        self._free: list[Any] = []
        self._loop: asyncio.AbstractEventLoop | None = None
        self._open: set[asyncio.Future[tuple[int, Values]]] = set()
        self._calls: set[asyncio.Future[Values]] = set()
        self._look_at: dict[str, float] = {}

    async def open(self) -> None:
        self._loop = asyncio.get_running_loop()
        try:
            self._ros = await self._connection()
        except Exception as fault:  # roslibpy and its transport raise what they like
            LOG.exception("connecting to the rosbridge failed")
            await self.close()
            raise Gone(f"the rosbridge at {self._url} cannot be reached: {fault}") from fault

    async def _connection(self) -> Any:
        # Its asyncio transport has its own loop and thread, and ends with the last of them.
        ros = self._roslibpy.Ros(self._url, transport="asyncio")
        ros.on("close", self._in_loop(lambda *_: self._lose()))
        self._all.append(ros)
        await asyncio.to_thread(ros.run, OPEN_S)
        return ros

    async def _own_connection(self, until: "asyncio.Future[Any]") -> Any:
        """One on which nothing is under way."""
        free = [ros for ros in self._free if ros.is_connected]
        if free:
            self._free.remove(free[0])
        try:
            ros = free[0] if free else await self._connection()
        except Exception as fault:  # as in `open`
            raise Gone(f"the rosbridge at {self._url} cannot be reached: {fault}") from fault
        until.add_done_callback(lambda _: self._free.append(ros))
        return ros

    async def close(self) -> None:
        self._ros = None
        while self._all:
            await asyncio.to_thread(self._all.pop().close, OPEN_S)

    @property
    def connected(self) -> bool:
        return self._ros is not None and bool(self._ros.is_connected)

    async def send(
        self, action: str, type: str, goal: Values, feedback: Callable[[Values], None], id: bytes
    ) -> Sent:
        self._check()
        assert self._loop is not None
        ended: asyncio.Future[tuple[int, Values]] = self._loop.create_future()
        ros = await self._own_connection(ended)
        self._open.add(ended)
        ended.add_done_callback(self._open.discard)
        # Its ids are those of all clients of a rosbridge: a cancel of theirs would cancel ours.
        named = {"action": action, "id": f"send_action_goal:{action}:{id.hex()}"}
        sending = {"op": "send_action_goal", **named, "action_type": type, "args": goal}

        def over(result: Any) -> None:
            values = result["values"]
            resolve(ended, (result["status"].value, values if isinstance(values, dict) else {}))

        def failed(result: Any) -> None:
            resolve(ended, Rejected(str(result.get("values", result))))

        ros.call_async_action(
            self._roslibpy.Message({**sending, "feedback": True}),
            self._in_loop(over),
            self._in_loop(feedback),
            self._in_loop(failed),
        )
        return Sent(ended, lambda: self._cancel(ros, named, ended, CANCEL_AGAIN_S))

    def _cancel(
        self, own: Any, named: Values, ended: "asyncio.Future[Any]", again_s: tuple[float, ...]
    ) -> None:
        if ended.done() or not self.connected:
            return
        message = self._roslibpy.Message({"op": "cancel_action_goal", **named})
        for ros in (own, self._ros):  # some take it from the goal's own connection alone
            ros.send_on_ready(message)
        if again_s:
            assert self._loop is not None
            self._loop.call_later(again_s[0], self._cancel, own, named, ended, again_s[1:])

    async def call(self, service: str, type: str, request: Values) -> Values:
        self._check()
        assert self._loop is not None
        answered: asyncio.Future[Values] = self._loop.create_future()
        ros = await self._own_connection(answered)
        self._calls.add(answered)
        answered.add_done_callback(self._calls.discard)
        # After a time that is up nobody waits for it any more.
        answered.add_done_callback(lambda one: one.cancelled() or one.exception())

        def over(response: Any) -> None:
            resolve(answered, dict(response))

        def failed(why: Any) -> None:
            resolve(answered, Rejected(str(why)))

        client = self._roslibpy.Service(ros, service, type)
        client.call(
            self._roslibpy.ServiceRequest(request), self._in_loop(over), self._in_loop(failed)
        )
        return await asyncio.shield(answered)

    async def cancel_left(self, action: str, id: bytes) -> None:
        try:  # no id and no time: all of them; the bridge chose the id
            await self._canceled(action, {})
        except Rejected:
            return  # there is no such server
        except TimeoutError as fault:
            raise Gone(
                f"the cancel of goals of {action} was not answered in {OPEN_S:g} s"
            ) from fault

    async def serves(self, action: str, type: str) -> bool:
        """Ask the server to cancel a goal that nobody has sent.

        The lists of rosapi say nothing of it: an action is in them as long as the bridge itself has a
        client for it.
        """
        assert self._loop is not None
        if self._loop.time() < self._look_at.get(action, 0.0):
            return True
        try:
            await self._canceled(action, {"goal_info": {"goal_id": {"uuid": list(uuid4().bytes)}}})
        except Rejected:
            return False
        except TimeoutError:
            pass  # a slow answer says nothing about the robot
        self._look_at[action] = self._loop.time() + LOOK_S
        return True

    async def _canceled(self, action: str, request: Values) -> None:
        async with asyncio.timeout(OPEN_S):
            await self.call(f"{action}/_action/cancel_goal", CANCEL, request)

    def listen(
        self, topic: str, type: str, heard: Callable[[Values], None], qos: dict[str, Any]
    ) -> None:
        self._check()
        self._roslibpy.Topic(self._ros, topic, type).subscribe(self._in_loop(heard))

    def _check(self) -> None:
        if not self.connected:
            raise Gone(f"there is no connection to the rosbridge at {self._url}")

    def _lose(self) -> None:
        for ended in [*self._open, *self._calls]:
            resolve(ended, Gone(f"the connection to the rosbridge at {self._url} broke"))

    def _in_loop(self, receive: Callable[..., None]) -> Callable[..., None]:
        """The same, called from roslibpy's thread."""
        loop = self._loop
        assert loop is not None

        def pass_on(*given: Any) -> None:
            if not loop.is_closed():
                loop.call_soon_threadsafe(receive, *given)

        return pass_on
