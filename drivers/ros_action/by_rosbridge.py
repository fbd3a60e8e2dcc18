"""Through a rosbridge, with roslibpy; it reconnects by itself."""

import asyncio
import logging
from collections.abc import Callable
from typing import Any

from ...system.extras import not_installed
from .bridge import Bridge, Gone, Rejected, Sent, Values, resolve

OPEN_S = 5.0
SERVERS = "/rosapi/action_servers"
LOG = logging.getLogger("labrun")


class RosbridgeWay(Bridge):
    """`url`: `ws://HOST:PORT`, with `/?token=...` if the bridge requires one."""

    def __init__(self, url: str) -> None:
        try:
            import roslibpy
        except ImportError as fault:
            raise ValueError(not_installed(fault) or str(fault)) from fault
        self._roslibpy: Any = roslibpy
        self._url = url
        self._ros: Any = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._open: set[asyncio.Future[tuple[int, Values]]] = set()
        self._calls: set[asyncio.Future[Values]] = set()
        self._no_rosapi = False

    async def open(self) -> None:
        self._loop = asyncio.get_running_loop()
        # Its asyncio transport has its own loop and thread, and ends with the last of them.
        self._ros = self._roslibpy.Ros(self._url, transport="asyncio")
        self._ros.on("close", self._in_loop(lambda *_: self._lose()))
        try:
            await asyncio.to_thread(self._ros.run, OPEN_S)
        except Exception as fault:  # roslibpy and its transport raise what they like
            LOG.exception("connecting to the rosbridge failed")
            await self.close()
            raise Gone(f"the rosbridge at {self._url} cannot be reached: {fault}") from fault

    async def close(self) -> None:
        ros, self._ros = self._ros, None
        if ros is not None:
            await asyncio.to_thread(ros.close, OPEN_S)

    @property
    def connected(self) -> bool:
        return self._ros is not None and bool(self._ros.is_connected)

    def send(
        self, action: str, type: str, goal: Values, feedback: Callable[[Values], None], id: bytes
    ) -> Sent:
        self._check()
        assert self._loop is not None
        ended: asyncio.Future[tuple[int, Values]] = self._loop.create_future()
        self._open.add(ended)
        ended.add_done_callback(self._open.discard)
        client = self._roslibpy.ActionClient(self._ros, action, type)

        def over(result: Any) -> None:
            values = result["values"]
            resolve(ended, (result["status"].value, values if isinstance(values, dict) else {}))

        def failed(result: Any) -> None:
            resolve(ended, Rejected(str(result.get("values", result))))

        key = client.send_goal(
            self._roslibpy.Goal(goal),
            self._in_loop(over),
            self._in_loop(feedback),
            self._in_loop(failed),
        )
        return Sent(ended, lambda: client.cancel_goal(key))

    def call(self, service: str, type: str, request: Values) -> "asyncio.Future[Values]":
        self._check()
        assert self._loop is not None
        answered: asyncio.Future[Values] = self._loop.create_future()
        self._calls.add(answered)
        answered.add_done_callback(self._calls.discard)

        def over(response: Any) -> None:
            resolve(answered, dict(response))

        def failed(why: Any) -> None:
            resolve(answered, Rejected(str(why)))

        client = self._roslibpy.Service(self._ros, service, type)
        client.call(
            self._roslibpy.ServiceRequest(request), self._in_loop(over), self._in_loop(failed)
        )
        return answered

    async def cancel_left(self, action: str, id: bytes) -> None:
        # No id and no time: all of them (action_msgs/srv/CancelGoal); the bridge chose the id.
        try:
            async with asyncio.timeout(OPEN_S):
                await self.call(f"{action}/_action/cancel_goal", "action_msgs/srv/CancelGoal", {})
        except Rejected:
            return  # there is no such server
        except TimeoutError as fault:
            raise Gone(
                f"the cancel of goals of {action} was not answered in {OPEN_S:g} s"
            ) from fault

    async def serves(self, action: str, type: str) -> bool:
        if self._no_rosapi:
            return True
        try:
            async with asyncio.timeout(OPEN_S):
                told = await self.call(SERVERS, "rosapi_msgs/srv/GetActionServers", {})
        except Rejected:
            self._no_rosapi = True
            return True
        except TimeoutError:
            return True  # a slow answer says nothing about the robot
        return action in told.get("action_servers", [action])

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
