"""`/gantry_status`: the gantry's position from the zero of `/set_zero`, and its state.

Told twice a second, as by the paper's node, and on every change.
"""

from ..interfaces.values import to_ros
from ..offers.offer import Topic, Values
from .kinds import GANTRY_STATUS
from .paper import AXES, Paper

WORDS = {
    "idle": "Idle", "moving": "Run", "homing": "Running", "alarm": "Alarm", "hold": "Hold",
    "offline": "Offline",
}  # fmt: skip


def add(paper: Paper, name: str, device: str) -> None:
    """Offer it."""
    topic = Topic(name, GANTRY_STATUS)
    paper.offered.offers.topics[name] = topic

    def tell(status: Values) -> None:
        if not status:
            return
        zero = paper.zero(device)
        place = {axis: status[axis] - zero[axis] for axis in AXES if status.get(axis) is not None}
        work = WORDS.get(status.get("state", ""), "Pending") if paper.online(device) else "Offline"
        topic.publish(to_ros(GANTRY_STATUS, {"work": work, **place}))

    paper.offered.on_status(device, tell)
    paper.tells(lambda: tell(paper.status(device)))
