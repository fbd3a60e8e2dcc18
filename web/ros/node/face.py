"""The node: an action server per action, a topic per status, a service per pure action."""

# rclpy exists only where ROS is installed.
# pyright: reportMissingImports=false

import asyncio
import logging
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions

from ..offers.goals import Goals
from ..offers.offer import Offers, Refused, Service, Topic, Values
from .action_face import ActionFace
from .crossing import Crossing
from .messages import fill, from_message

NAME = "labrun"
LAST_WORDS_S = 0.5
LATCHED = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
)
LOG = logging.getLogger(__name__)


@asynccontextmanager
async def node(offers: Offers, goals: Goals, types: dict[str, Any]) -> AsyncIterator[Node]:
    """The node, spinning in a separate thread while the block runs."""
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    made = rclpy.create_node(NAME)
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
    thread = threading.Thread(target=_spin, args=(executor,), name="rclpy", daemon=True)
    thread.start()
    try:
        yield made
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
    try:
        executor.spin()
    except ExternalShutdownException:
        pass
    except Exception:  # the end of the thread, which nothing awaits
        LOG.exception("the ROS node crashed")


def _publish(node: Node, topic: Topic, cls: Any) -> Callable[[], None]:
    """Publish a topic; returns a function that stops it."""
    publisher = node.create_publisher(cls, topic.name, LATCHED)

    def tell(values: Values) -> None:
        publisher.publish(fill(topic.kind, cls(), values))

    topic.listen(tell)
    return lambda: topic.leave(tell)


def _serve(node: Node, service: Service, cls: Any, crossing: Crossing) -> None:
    async def answer(request: Any, response: Any) -> Any:
        values = from_message(service.kind.request, request)
        told: Values = await crossing.over(_answered(service, values))
        return fill(service.kind.response, response, told)

    node.create_service(cls, service.name, answer)


async def _answered(service: Service, values: Values) -> Values:
    try:
        return await service.answer(values)
    except Refused as fault:  # a ROS service cannot fail: the response must report it, or the log
        LOG.warning("%s: a call is refused: %s", service.name, fault)
        return service.refused(str(fault))
