"""The ways in which a GRBL controller fails a request, beside those of every gantry."""

from ...schemas.contract import Happened
from ..motion.faults import MotionFault, Refused
from .firmware import GRBL, Firmware


class GrblRefused(Refused):
    """`error:N`: the line was not accepted."""

    def __init__(self, code: int, firmware: Firmware = GRBL) -> None:
        super().__init__(f"it answered {firmware.error(code)}")
        self.code = code
        self.error = "SoftLimit" if code == 15 else "Alarm"


SOFT_LIMIT = 2


def reset_in_homing(code: int) -> int:
    """The alarm of a reset that was asked for: 8 or 9 instead of 6 where a switch is engaged just then."""
    return 6 if code in (8, 9) else code


class Alarmed(MotionFault):
    """`ALARM:N` while a line was being executed."""

    def __init__(self, code: int, firmware: Firmware = GRBL) -> None:
        super().__init__(f"it answered {firmware.alarm(code)}")
        self.code = code


class StillLocked(MotionFault):
    """It has not responded since an alarm, so nothing was sent."""

    happened: Happened = "no"
