"""`/is_gantry_rdy` and `/is_analytical_dev_rdy`: whether a device stands still and would take a goal now."""

from ..offers.offer import Values
from .kinds import IS_RDY
from .paper import PaperService


class IsReady(PaperService):
    """No goal of ROS is under way on the device, and a state that it reports is `idle`."""

    kind = IS_RDY

    async def answer(self, values: Values) -> Values:
        """`{ready}`."""
        idle = self.paper.status(self.device).get("state", "idle") == "idle"
        online, busy = self.paper.online(self.device), self.paper.busy(self.device)
        return {"ready": online and idle and not busy}
