"""`/set_zero`: set the zero of an axis at its present position."""

from ..offers.offer import Refused, Values
from .kinds import SET_ZERO
from .paper import AXES, PaperService


class SetZero(PaperService):
    """For `/move_gantry` and `/gantry_status` only: protocols use bench coordinates."""

    kind = SET_ZERO

    async def answer(self, values: Values) -> Values:
        """`{}`: the paper's response has no field; raises Refused."""
        axes = values.get("axis") if isinstance(values, dict) else None
        wanted = list(axes.lower()) if isinstance(axes, str) else []
        if not wanted or not set(wanted) <= {*AXES}:
            raise Refused(f"axis must be x, y, z or several of them, not {str(axes)[:40]!r}")
        status = await self.paper.status_from_now(self.device)
        if status.get("state") in ("moving", "homing"):
            raise Refused(f"{self.device} is {status['state']}; set the zero when it has stopped")
        unknown = [axis for axis in wanted if status.get(axis) is None]
        if unknown:
            raise Refused(f"{self.device} does not report its {unknown[0]} position")
        try:
            self.paper.set_zero(self.device, {axis: status[axis] for axis in wanted})
        except OSError as fault:
            raise Refused(f"the zero cannot be stored: {fault.strerror}") from fault
        return {}
