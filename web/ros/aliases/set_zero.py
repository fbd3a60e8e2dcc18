"""`/set_zero`: count an axis from where it stands now."""

from ..offer import Refused, Service, Values
from .kinds import SET_ZERO
from .paper import AXES, Paper

NAME, CONTRACT = "/set_zero", "gantry@1"


def add(paper: Paper, name: str, device: str) -> None:
    """Offer it."""
    paper.site.offers.services[name] = SetZero(paper, name, device)


class SetZero(Service):
    """For `/move_gantry` and `/gantry_status` alone: protocols speak of the bench."""

    kind = SET_ZERO

    def __init__(self, paper: Paper, name: str, device: str) -> None:
        self.name = name
        self._paper = paper
        self._device = device

    async def answer(self, values: Values) -> Values:
        """`{success, message}`; raises Refused."""
        axes = values.get("axis") if isinstance(values, dict) else None
        wanted = list(axes.lower()) if isinstance(axes, str) else []
        if not wanted or not set(wanted) <= {*AXES}:
            raise Refused(f"axis is x, y, z or several of them, not {str(axes)[:40]!r}")
        status = self._paper.status(self._device)
        unknown = [axis for axis in wanted if status.get(axis) is None]
        if unknown:
            raise Refused(f"{self._device} does not say where it stands in {unknown[0]}")
        try:
            self._paper.set_zero(self._device, {axis: status[axis] for axis in wanted})
        except OSError as fault:
            raise Refused(f"the zero cannot be kept: {fault.strerror}") from fault
        return {"success": True, "message": f"{', '.join(wanted)} count from here"}
