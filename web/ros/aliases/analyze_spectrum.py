"""`/analyze_spectrum`: the areas of the peaks in the last spectrum, by the lab's reducer."""

from ..offers.offer import End, Refused, Work
from .kinds import ANALYZE_SPECTRUM
from .paper import PaperAction


class AnalyzeSpectrum(PaperAction):
    """Takes elements where the paper's program takes one window of wavelengths."""

    kind = ANALYZE_SPECTRUM

    async def carry(self, work: Work) -> End:
        """Reduce; `peak_range[i]` is an element, `peak_area[i]` the area of its predominant peak."""
        if self.paper.file is None:
            raise Refused(
                "no spectrum has been exported yet: send a goal to /export_spectrum first"
            )
        reduce = self.paper.action(self.device, "reduce")
        inner = self.part(work)
        params = reduce.checked({"spectrum": self.paper.file})
        outcome = await reduce.sent(params, inner)
        areas = (outcome.result or {}).get("areas", {})
        found = {element: area for element, area in areas.items() if area is not None}
        return self.ended(
            work, reduce.ending(outcome, inner),
            peak_range=list(found), peak_area=list(found.values()),
        )  # fmt: skip
