"""Every operation that a client may request."""

from .client import Client, Message, Operation
from .frames import Misformed
from .goal_ops import cancel_action_goal, send_action_goal
from .service_ops import call_service
from .topic_ops import subscribe, unsubscribe


def _not_here(client: Client, message: Message) -> None:
    raise Misformed(
        f"`{message['op']}` is not supported here: labrun offers its devices, and takes part in "
        "another ROS system by its driver `ros_action`, or as a node (`labrun ros --node`)"
    )


def _nothing(client: Client, message: Message) -> None:
    """Operations sent before disconnecting, or without effect here."""


OPERATIONS: dict[str, Operation] = {
    "send_action_goal": send_action_goal,
    "cancel_action_goal": cancel_action_goal,
    "call_service": call_service,
    "subscribe": subscribe,
    "unsubscribe": unsubscribe,
    "set_level": Client.set_level,
    "status": _nothing,
    "auth": _nothing,
    "unadvertise": _nothing,
    "advertise": _not_here,
    "publish": _not_here,
    "advertise_service": _not_here,
    "unadvertise_service": _not_here,
    "service_response": _not_here,
    "advertise_action": _not_here,
    "unadvertise_action": _not_here,
    "action_feedback": _not_here,
    "action_result": _not_here,
}
