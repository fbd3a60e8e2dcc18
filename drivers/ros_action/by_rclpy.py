"""As a node of the installed ROS 2, through rclpy."""

# rclpy is only available with ROS.
# pyright: reportMissingImports=false

import asyncio
import importlib
import logging
import threading
import time
from collections.abc import Callable
from typing import Any

from ...system.tasks import spawn
from .bridge import Bridge, Gone, Rejected, Sent, Values
from .ros_message import as_values, fill

FOUND_S = 10.0
AGAIN_S = 0.1
LOG = logging.getLogger("labrun")


class RclpyWay(Bridge):
    """A separate node, spinning in its own thread."""

    def __init__(self) -> None:
        try:
            import rclpy
        except ImportError as fault:
            raise ValueError(
                f"there is no ROS 2 in this Python ({fault}): source your ROS first, or give `bridge:`"
            ) from fault
        self._rclpy: Any = rclpy
        self._context: Any = None
        self._node: Any = None
        self._executor: Any = None
        self._thread: threading.Thread | None = None
        self._clients: dict[str, Any] = {}
        self._cancelling: dict[str, Any] = {}
        self._loop: asyncio.AbstractEventLoop | None = None

    async def open(self) -> None:
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.signals import SignalHandlerOptions

        self._loop = asyncio.get_running_loop()
        self._context = self._rclpy.Context()
        self._rclpy.init(context=self._context, signal_handler_options=SignalHandlerOptions.NO)
        self._node = self._rclpy.create_node("labrun_device", context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._spin, name="rclpy", daemon=True)
        self._thread.start()

    async def close(self) -> None:
        if self._thread is None:
            return
        self._executor.shutdown(timeout_sec=2)
        self._rclpy.try_shutdown(context=self._context)
        await asyncio.to_thread(self._thread.join, 5)
        for client in self._clients.values():
            client.destroy()
        self._node.destroy_node()
        self._thread = None

    @property
    def connected(self) -> bool:
        return self._thread is not None and self._thread.is_alive()

    def send(
        self, action: str, type: str, goal: Values, feedback: Callable[[Values], None]
    ) -> Sent:
        from rclpy.action import ActionClient

        if not self.connected:
            raise Gone("the ROS node has ended")
        assert self._loop is not None
        cls = _class_of(type)
        try:
            message = fill(cls.Goal(), goal)
        except (AttributeError, TypeError, ValueError, AssertionError) as fault:
            raise Rejected(f"the goal does not fit {type}: {fault}") from fault
        client = self._clients.get(action)
        if client is None:
            client = self._clients[action] = ActionClient(self._node, cls, action)
        under_way = _UnderWay(self._loop, self._executor)
        looking = spawn(f"a goal for {action}", _send(client, message, under_way, feedback, action))
        looking.add_done_callback(under_way.sent)
        under_way.ended.add_done_callback(lambda _: looking.cancel())
        return Sent(under_way.ended, under_way.cancel)

    def cancel_all(self, action: str) -> None:
        from action_msgs.srv import CancelGoal

        if not self.connected:
            raise Gone("the ROS node has ended")
        if action not in self._cancelling:
            name = f"{action}/_action/cancel_goal"
            self._cancelling[action] = self._node.create_client(CancelGoal, name)
        # No id and no time: all of them.
        self._cancelling[action].call_async(CancelGoal.Request())
        self._executor.wake()

    def listen(self, topic: str, type: str, heard: Callable[[Values], None]) -> None:
        loop = self._loop
        assert loop is not None
        self._node.create_subscription(
            _class_of(type), topic, lambda m: loop.call_soon_threadsafe(heard, as_values(m)), 10
        )
        self._executor.wake()

    def _spin(self) -> None:
        from rclpy.executors import ExternalShutdownException

        while True:
            try:
                self._executor.spin()
            except ExternalShutdownException:
                return
            except Exception:  # of one callback: the goals of the others still need this thread
                LOG.exception("a message from ROS could not be taken")
                time.sleep(AGAIN_S)
            else:
                return


class _UnderWay:
    """One goal as seen from our loop; ROS calls back from its own thread."""

    def __init__(self, loop: asyncio.AbstractEventLoop, executor: Any) -> None:
        self.ended: asyncio.Future[tuple[int, Values]] = loop.create_future()
        self.loop = loop
        self._executor = executor
        self._handle: Any = None
        self._cancel_wanted = False

    def cancel(self) -> None:
        self._cancel_wanted = True
        if self._handle is not None:
            self._handle.cancel_goal_async()
            self._executor.wake()

    def sent(self, looking: "asyncio.Task[None]") -> None:
        """It was sent, or could not be; then nothing else would end the goal."""
        if not looking.cancelled() and (fault := looking.exception()) is not None:
            self.resolve(Gone(f"it could not be sent: {fault}"))

    def answered(self, future: Any) -> None:
        """In ROS's thread: the goal was accepted or not."""
        self._heard(future.result, self._taken)

    def _taken(self, handle: Any) -> None:
        if handle is None or not handle.accepted:
            self.resolve(Rejected("the action server rejected the goal"))
            return
        self._handle = handle
        handle.get_result_async().add_done_callback(self._resulted)
        if self._cancel_wanted:
            handle.cancel_goal_async()
        self._executor.wake()

    def _resulted(self, future: Any) -> None:
        def outcome() -> tuple[int, Values]:
            answer = future.result()
            return answer.status, as_values(answer.result)

        self._heard(outcome, self.resolve)

    def _heard(self, read: Callable[[], Any], take: Callable[[Any], None]) -> None:
        """In ROS's thread: pass an answer on, or end the goal with the reason why there is none."""
        try:
            answer = read()
        except Exception as fault:  # whatever it is, nothing else would end the goal
            self.loop.call_soon_threadsafe(
                self.resolve, Gone(f"its answer cannot be read: {fault}")
            )
        else:
            self.loop.call_soon_threadsafe(take, answer)

    def resolve(self, said: Any) -> None:
        """The first outcome counts."""
        if self.ended.done():
            return
        if isinstance(said, Exception):
            self.ended.set_exception(said)
        else:
            self.ended.set_result(said)

    def wake(self) -> None:
        """Wake the executor, which would not notice a request from another thread."""
        self._executor.wake()


async def _send(
    client: Any, message: Any, under_way: _UnderWay, feedback: Callable[[Values], None], action: str
) -> None:
    loop = under_way.loop
    until = loop.time() + FOUND_S
    while not client.server_is_ready():
        if loop.time() > until:
            under_way.resolve(Rejected(f"no server for {action}"))
            return
        await asyncio.sleep(0.05)

    def tell(told: Any) -> None:
        loop.call_soon_threadsafe(feedback, as_values(told.feedback))

    client.send_goal_async(message, feedback_callback=tell).add_done_callback(under_way.answered)
    under_way.wake()


def _class_of(type: str) -> Any:
    package, _, rest = type.partition("/")
    group, _, name = rest.rpartition("/")
    try:
        return getattr(importlib.import_module(f"{package}.{group or 'action'}"), name)
    except (ImportError, AttributeError) as fault:
        raise Rejected(f"there is no interface {type} in this ROS: {fault}") from fault
