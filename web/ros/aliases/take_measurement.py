"""`/take_measurement`: one shot; `/export_spectrum` writes the last shot's spectrum."""

from ..offers.offer import End, Work
from .kinds import TAKE_MEASUREMENT
from .paper import Paper, PaperAction

NAME, CONTRACT = "/take_measurement", "libs_analyzer@1"


def add(paper: Paper, name: str, device: str) -> None:
    """Offer it."""
    paper.offered.offers.actions[name] = TakeMeasurement(paper, name, device, TAKE_MEASUREMENT)


class TakeMeasurement(PaperAction):
    """Remembers the shot."""

    said = "feedback"
    can_cancel = False

    async def carry(self, work: Work) -> End:
        """Fire."""
        end = await self.done(self.paper.action(self.device, "measure"), {}, work)
        if end.state == "SUCCEEDED":
            self.paper.shot = end.result["shot_id"]
        return self.ended(work, end)
