"""`/export_spectrum`: the spectrum of the last shot as a file."""

from datetime import datetime

from ..offer import End, Refused, Work
from .kinds import EXPORT_SPECTRUM
from .paper import Paper, PaperAction

NAME, CONTRACT = "/export_spectrum", "libs_analyzer@1"


def add(paper: Paper, name: str, device: str) -> None:
    """Offer it."""
    paper.site.offers.actions[name] = ExportSpectrum(paper, name, device, EXPORT_SPECTRUM)


class ExportSpectrum(PaperAction):
    """The file is called after the moment, as in the paper, and lies among the files of actions."""

    said = "feedback"
    can_cancel = False

    async def carry(self, work: Work) -> End:
        """Export; `msg` is the file."""
        if self.paper.shot is None:
            raise Refused("nothing was measured yet: send a goal to /take_measurement first")
        moment = datetime.now().astimezone()
        name = f"{moment:%Y_%m_%d_%H_%M_%S}_{moment.microsecond // 1000:03}.csv"
        export = self.paper.action(self.device, "export")
        end = await self.done(export, {"shot": self.paper.shot, "file": name}, work)
        if end.state == "SUCCEEDED":
            self.paper.file = end.result["file"]
        return self.ended(end, str(self.paper.site.folders.files / name))
