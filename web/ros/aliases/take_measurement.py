"""`/take_measurement`: one shot; `/export_spectrum` writes the last shot's spectrum."""

from ..offers.offer import End, Work
from .kinds import TAKE_MEASUREMENT
from .paper import PaperAction


class TakeMeasurement(PaperAction):
    """Remembers the shot."""

    kind = TAKE_MEASUREMENT

    async def carry(self, work: Work) -> End:
        """Fire."""
        end = await self.done(self.paper.action(self.device, "measure"), {}, work)
        if end.state == "SUCCEEDED":
            self.paper.shot = end.result["shot_id"]
        return self.ended(work, end)
