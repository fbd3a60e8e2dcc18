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
from .bridge import Bridge, Gone, Rejected, Sent, Values, resolve
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
        self._services: dict[str, Any] = {}
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

    async def send(
        self, action: str, type: str, goal: Values, feedback: Callable[[Values], None], id: bytes
    ) -> Sent:
        from rclpy.action import ActionClient

        if not self.connected:
            raise Gone("the ROS node has ended")
        assert self._loop is not None
        cls = class_of(type, "action")
        message = _filled(cls.Goal(), goal, type)
        client = self._clients.get(action)
        if client is None:
            client = self._clients[action] = ActionClient(self._node, cls, action)
        under_way = _UnderWay(self._loop, self._executor)
        looking = spawn(
            f"a goal for {action}", _send(client, message, under_way, feedback, action, id)
        )
        looking.add_done_callback(under_way.sent)
        under_way.ended.add_done_callback(lambda _: looking.cancel())
        return Sent(under_way.ended, under_way.cancel)

    async def call(self, service: str, type: str, request: Values) -> Values:
        if not self.connected:
            raise Gone("the ROS node has ended")
        assert self._loop is not None
        cls = class_of(type, "srv")
        message = _filled(cls.Request(), request, type)
        client = self._services.get(service)
        if client is None:
            client = self._services[service] = self._node.create_client(cls, service)
        answered: asyncio.Future[Values] = self._loop.create_future()
        calling = spawn(f"a call of {service}", self._call(client, message, answered, service))
        answered.add_done_callback(lambda _: calling.cancel())
        return await answered

    async def _call(
        self, client: Any, message: Any, answered: "asyncio.Future[Values]", service: str
    ) -> None:
        loop = asyncio.get_running_loop()
        if not await _ready(client.service_is_ready):
            resolve(answered, Rejected(f"there is no service {service}"))
            return

        def answer(future: Any) -> None:  # in ROS's thread
            try:
                said: Any = as_values(future.result())
            except Exception as fault:  # whatever it is, nothing else would end the call
                LOG.exception("an answer of a service cannot be read")
                said = Gone(f"its answer cannot be read: {fault}")
            loop.call_soon_threadsafe(resolve, answered, said)

        client.call_async(message).add_done_callback(answer)
        self._executor.wake()
        await asyncio.wait({answered})

    async def cancel_left(self, action: str, id: bytes) -> None:
        request = {"goal_info": {"goal_id": {"uuid": list(id)}}}
        try:
            async with asyncio.timeout(2 * FOUND_S):
                await self.call(
                    f"{action}/_action/cancel_goal", "action_msgs/srv/CancelGoal", request
                )
        except Rejected:
            return  # there is no such server
        except TimeoutError as fault:
            raise Gone(f"the cancel of a goal of {action} was not answered") from fault

    async def serves(self, action: str, type: str) -> bool:
        client = self._clients.get(action)
        return self.connected and (client is None or client.server_is_ready())

    def listen(
        self, topic: str, type: str, heard: Callable[[Values], None], qos: dict[str, Any]
    ) -> None:
        from rclpy.event_handler import SubscriptionEventCallbacks
        from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

        loop = self._loop
        assert loop is not None

        def differs(event: Any) -> None:
            LOG.warning(
                "%s is published with another quality of service, and nothing will be heard: give "
                "`qos: {reliability: best_effort}` or what `ros2 topic info -v` shows",
                topic,
            )

        profile = QoSProfile(
            depth=qos.get("depth", 1),
            reliability=ReliabilityPolicy[qos.get("reliability", "reliable").upper()],
            durability=DurabilityPolicy[qos.get("durability", "volatile").upper()],
        )
        self._node.create_subscription(
            class_of(type, "msg"), topic,
            lambda m: loop.call_soon_threadsafe(heard, as_values(m)), profile,
            event_callbacks=SubscriptionEventCallbacks(incompatible_qos=differs),
        )  # fmt: skip
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
            LOG.exception("an answer of an action cannot be read")
            self.loop.call_soon_threadsafe(
                self.resolve, Gone(f"its answer cannot be read: {fault}")
            )
        else:
            self.loop.call_soon_threadsafe(take, answer)

    def resolve(self, said: Any) -> None:
        """The first outcome counts."""
        resolve(self.ended, said)

    def wake(self) -> None:
        """Wake the executor, which would not notice a request from another thread."""
        self._executor.wake()


async def _ready(is_ready: Callable[[], bool]) -> bool:
    loop = asyncio.get_running_loop()
    until = loop.time() + FOUND_S
    while not is_ready():
        if loop.time() > until:
            return False
        await asyncio.sleep(0.05)
    return True


async def _send(
    client: Any, message: Any, under_way: _UnderWay, feedback: Callable[[Values], None],
    action: str, id: bytes,
) -> None:  # fmt: skip
    from unique_identifier_msgs.msg import UUID

    loop = under_way.loop
    if not await _ready(client.server_is_ready):
        under_way.resolve(Rejected(f"no server for {action}"))
        return

    def tell(told: Any) -> None:
        loop.call_soon_threadsafe(feedback, as_values(told.feedback))

    sending = client.send_goal_async(message, feedback_callback=tell, goal_uuid=UUID(uuid=list(id)))
    sending.add_done_callback(under_way.answered)
    under_way.wake()


def _filled(message: Any, values: Values, type: str) -> Any:
    try:
        return fill(message, values)
    except (AttributeError, TypeError, ValueError, AssertionError) as fault:
        raise Rejected(f"the goal does not fit {type}: {fault}") from fault


def class_of(type: str, group: str) -> Any:
    """The class of `pkg/action/Name`, or `pkg/Name` of a group; raises Rejected."""
    package, _, rest = type.partition("/")
    given, _, name = rest.rpartition("/")
    try:
        return getattr(importlib.import_module(f"{package}.{given or group}"), name)
    except (ImportError, AttributeError) as fault:
        raise Rejected(f"there is no interface {type} in this ROS: {fault}") from fault
