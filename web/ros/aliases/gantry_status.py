"""`/gantry_status`: the gantry's position from the zero of `/set_zero`, and its state."""

from ..interfaces.values import to_ros
from ..offers.offer import Topic, Values
from .kinds import GANTRY_STATUS
from .paper import AXES, Paper

NAME, CONTRACT = "/gantry_status", "gantry@1"
WORDS = {
    "idle": "Idle", "moving": "Run", "homing": "Running", "alarm": "Alarm", "hold": "Hold",
    "offline": "Offline",
}  # fmt: skip


def add(paper: Paper, name: str, device: str) -> None:
    """Offer it."""
    topic = Topic(name, GANTRY_STATUS)
    paper.offered.offers.topics[name] = topic

    def tell(status: Values) -> None:
        zero = paper.zero(device)
        place = {axis: status[axis] - zero[axis] for axis in AXES if status.get(axis) is not None}
        work = WORDS.get(status.get("state", ""), "Pending")
        topic.publish(to_ros(GANTRY_STATUS, {"work": work, **place}))

    def moved() -> None:
        if paper.status(device):
            tell(paper.status(device))

    paper.offered.on_status(device, tell)
    paper.on_zero(moved)
