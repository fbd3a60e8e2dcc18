"""`/z300_status`: IDLE or RUNNING, twice a second; the paper's tree listens to it."""

from ..interfaces.own_kinds import STRING
from ..offers.offer import Topic
from .paper import Paper


def add(paper: Paper, name: str, device: str) -> None:
    """Offer it; a device that does not answer is OFFLINE."""
    topic = Topic(name, STRING)
    paper.offered.offers.topics[name] = topic

    def tell() -> None:
        word = "RUNNING" if paper.busy(device) else "IDLE"
        topic.publish({"data": word if paper.online(device) else "OFFLINE"})

    paper.tells(tell)
