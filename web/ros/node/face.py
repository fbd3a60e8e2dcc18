"""The node: an action server per action, a topic per status, a service per pure action."""

# rclpy exists only where ROS is installed.
# pyright: reportMissingImports=false

import asyncio
import logging
import threading
import time
from collections import deque
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager, suppress
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions

from ..interfaces.fault import RosFault
from ..offers.goals import Goals
from ..offers.offer import Offers, Refused, Service, Topic, Values
from .action_face import ActionFace
from .crossing import Crossing
from .messages import fill, from_message

NAME = "labrun"
LAST_WORDS_S = 0.5
MOST_FAILURES, FAILURES_S = 5, 10.0
LATCHED = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
)
LOG = logging.getLogger(__name__)


@asynccontextmanager
async def node(
    offers: Offers, goals: Goals, types: dict[str, Any], ros_args: Sequence[str] = ()
) -> AsyncIterator[tuple[Node, asyncio.Event]]:
    """The node, spinning in a separate thread while the block runs, and an event: it has ended.

    Its names are relative, so that `ros_args` may give it a namespace. Raises RosFault.
    """
    given = ["labrun", "--ros-args", *ros_args] if ros_args else ["labrun"]
    try:
        rclpy.init(args=given, signal_handler_options=SignalHandlerOptions.NO)
        made = rclpy.create_node(NAME)
    except Exception as fault:  # rclpy has a class of its own for each
        rclpy.try_shutdown()
        raise RosFault(f"--ros-args {' '.join(ros_args)}: {fault}") from fault
    executor = SingleThreadedExecutor()
    executor.add_node(made)
    crossing = Crossing(asyncio.get_running_loop(), executor)
    faces = [
        ActionFace(made, one, types[one.kind.type], goals, crossing)
        for one in offers.actions.values()
    ]
    for service in offers.services.values():
        _serve(made, service, types[service.kind.type], crossing)
    published = [_publish(made, topic, types[topic.kind.type]) for topic in offers.topics.values()]
    died, loop = asyncio.Event(), asyncio.get_running_loop()

    def spun() -> None:
        _spin(executor)
        with suppress(RuntimeError):  # our loop has ended, too
            loop.call_soon_threadsafe(died.set)

    thread = threading.Thread(target=spun, name="rclpy", daemon=True)
    thread.start()
    try:
        yield made, died
    finally:
        await goals.close()
        await asyncio.sleep(LAST_WORDS_S)  # results are still being sent in the other thread
        for leave in published:
            leave()
        executor.shutdown(timeout_sec=2)
        rclpy.try_shutdown()
        await asyncio.to_thread(thread.join, 5)
        for face in faces:
            face.server.destroy()
        made.destroy_node()


def _spin(executor: SingleThreadedExecutor) -> None:
    failures: deque[float] = deque(maxlen=MOST_FAILURES)
    while len(failures) < MOST_FAILURES or time.monotonic() - failures[0] > FAILURES_S:
        try:
            executor.spin()
        except ExternalShutdownException:
            return
        except Exception:  # of one callback: the goals of the others still need this thread
            LOG.exception("a message from ROS could not be taken")
            failures.append(time.monotonic())
        else:
            return
    LOG.error("the node ends: %d failures within %g s", MOST_FAILURES, FAILURES_S)


def _publish(node: Node, topic: Topic, cls: Any) -> Callable[[], None]:
    """Publish a topic; returns a function that stops it."""
    publisher = node.create_publisher(cls, topic.name[1:], LATCHED)

    def tell(values: Values) -> None:
        publisher.publish(fill(topic.kind, cls(), values))

    topic.listen(tell)
    return lambda: topic.leave(tell)


def _serve(node: Node, service: Service, cls: Any, crossing: Crossing) -> None:
    async def answer(request: Any, response: Any) -> Any:
        values = from_message(service.kind.request, request)
        told: Values = await crossing.over(_answered(service, values))
        return fill(service.kind.response, response, told)

    node.create_service(cls, service.name[1:], answer)


async def _answered(service: Service, values: Values) -> Values:
    try:
        return await service.answer(values)
    except Refused as fault:  # a ROS service cannot fail: the response must report it, or the log
        LOG.warning("%s: a call is refused: %s", service.name, fault)
        return service.refused(str(fault))
