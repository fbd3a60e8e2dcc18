"""`/is_gantry_rdy`: whether the gantry stands still and would take a goal now."""

from ..offers.offer import Service, Values
from .kinds import IS_RDY
from .paper import Paper

NAME, CONTRACT = "/is_gantry_rdy", "gantry@1"


def add(paper: Paper, name: str, device: str) -> None:
    """Offer it."""
    paper.offered.offers.services[name] = IsReady(paper, name, device)


class IsReady(Service):
    """No goal of ROS is under way on the device, and a state that it reports is `idle`."""

    kind = IS_RDY

    def __init__(self, paper: Paper, name: str, device: str) -> None:
        self.name = name
        self._paper = paper
        self._device = device

    async def answer(self, values: Values) -> Values:
        """`{ready}`."""
        idle = self._paper.status(self._device).get("state", "idle") == "idle"
        online, busy = self._paper.online(self._device), self._paper.busy(self._device)
        return {"ready": online and idle and not busy}
