"""`/set_zero`: set the zero of an axis at its present position."""

from ..offers.offer import Refused, Service, Values
from .kinds import SET_ZERO
from .paper import AXES, Paper

NAME, CONTRACT = "/set_zero", "gantry@1"


def add(paper: Paper, name: str, device: str) -> None:
    """Offer it."""
    paper.offered.offers.services[name] = SetZero(paper, name, device)


class SetZero(Service):
    """For `/move_gantry` and `/gantry_status` only: protocols use bench coordinates."""

    kind = SET_ZERO

    def __init__(self, paper: Paper, name: str, device: str) -> None:
        self.name = name
        self._paper = paper
        self._device = device

    async def answer(self, values: Values) -> Values:
        """`{}`: the paper's response has no field; raises Refused."""
        axes = values.get("axis") if isinstance(values, dict) else None
        wanted = list(axes.lower()) if isinstance(axes, str) else []
        if not wanted or not set(wanted) <= {*AXES}:
            raise Refused(f"axis must be x, y, z or several of them, not {str(axes)[:40]!r}")
        status = await self._paper.status_from_now(self._device)
        if status.get("state") in ("moving", "homing"):
            raise Refused(f"{self._device} is {status['state']}; set the zero when it has stopped")
        unknown = [axis for axis in wanted if status.get(axis) is None]
        if unknown:
            raise Refused(f"{self._device} does not report its {unknown[0]} position")
        try:
            self._paper.set_zero(self._device, {axis: status[axis] for axis in wanted})
        except OSError as fault:
            raise Refused(f"the zero cannot be stored: {fault.strerror}") from fault
        return {}
