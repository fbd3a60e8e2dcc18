"""`/detect_samples`: where samples are, as /move_gantry counts, each with an id that it keeps."""

import math

from ..offers.offer import End, Values, Work
from .kinds import DETECT_SAMPLES
from .paper import PaperAction, device_of

MOVES = "/move_gantry"
MM_PER_M = 1000.0


class DetectSamples(PaperAction):
    """Places in m, as in the paper. `boxes` stays empty: the camera tells outlines on the bench."""

    kind = DETECT_SAMPLES

    def __init__(self, *given) -> None:
        super().__init__(*given)
        self._places: list[tuple[float, float]] = []

    async def carry(self, work: Work) -> End:
        """Look."""
        locate = self.paper.action(self.device, "locate_samples")
        inner = self.part(work)
        outcome = await locate.sent(locate.checked({}), inner)
        samples = (outcome.result or {}).get("samples", [])
        zero = self.paper.zero(self._gantry())
        return self.ended(
            work, locate.ending(outcome, inner), boxes=[],
            ids=[self._id(sample) for sample in samples],
            gantry_locs=[
                {
                    "x_g": (sample["x"] - zero["x"]) / MM_PER_M,
                    "y_g": (sample["y"] - zero["y"]) / MM_PER_M,
                    "z_g": (sample["height"] - zero["z"]) / MM_PER_M,
                }
                for sample in samples
            ],
        )  # fmt: skip

    def _gantry(self) -> str:
        """The device behind /move_gantry, whose zero counts."""
        moves = self.paper.offered.offers.actions.get(MOVES)
        return (device_of(moves) or "") if moves is not None else ""

    def _id(self, sample: Values) -> int:
        """The id under which a sample at this place was told before, or a new one, from 1."""
        here = (sample["x"], sample["y"])
        near = min(sample["right"] - sample["left"], sample["back"] - sample["front"]) / 2
        for number, there in enumerate(self._places):
            if math.dist(here, there) <= near:
                self._places[number] = here
                return number + 1
        self._places.append(here)
        return len(self._places)
