"""`/export_spectrum`: the spectrum of the last shot as a file."""

from datetime import datetime

from ..offers.offer import End, Refused, Work
from .kinds import EXPORT_SPECTRUM
from .paper import PaperAction


class ExportSpectrum(PaperAction):
    """The file is named after the time, as in the paper, and is in the folder of action files."""

    kind = EXPORT_SPECTRUM

    async def carry(self, work: Work) -> End:
        """Export; the last feedback is the file."""
        if self.paper.shot is None:
            raise Refused("nothing has been measured yet: send a goal to /take_measurement first")
        moment = datetime.now().astimezone()
        name = f"{moment:%Y_%m_%d_%H_%M_%S}_{moment.microsecond // 1000:03}.csv"
        export = self.paper.action(self.device, "export")
        end = await self.done(export, {"shot": self.paper.shot, "file": name}, work)
        if end.state == "SUCCEEDED":
            self.paper.file = end.result["file"]
        return self.ended(work, end, str(self.paper.offered.folders.files / name))
