"""The node: an action server for each action, a topic for each status, a service where it is pure."""

# rclpy is only where ROS is.
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

from ..goals import Goals
from ..offer import Offers, Refused, Service, Topic, Values
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
    """The node, spinning in a thread of its own for as long as the block lasts."""
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
        await asyncio.sleep(LAST_WORDS_S)  # the results are on their way in the other thread
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
    except Exception:
        LOG.exception("the node of ROS fell over")


def _publish(node: Node, topic: Topic, cls: Any) -> Callable[[], None]:
    """Publish a topic; what is returned ends that."""
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
    except Refused as fault:  # a service of ROS cannot fail: the response has to say so
        return service.refused(str(fault))
