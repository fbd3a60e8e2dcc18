"""The ways in which a GRBL controller fails a request, beside those of every gantry."""

from ...schemas.contract import Happened
from ..motion.faults import MotionFault, Refused
from .messages import alarm_words, error_words


class GrblRefused(Refused):
    """`error:N`: the line was not accepted."""

    def __init__(self, code: int, firmware: str = "") -> None:
        super().__init__(f"it answered {error_words(code, firmware)}")
        self.code = code
        self.error = "SoftLimit" if code == 15 else "Alarm"


class Alarmed(MotionFault):
    """`ALARM:N` while a line was being executed."""

    def __init__(self, code: int, firmware: str = "") -> None:
        super().__init__(f"it answered {alarm_words(code, firmware)}")
        self.code = code


class StillLocked(MotionFault):
    """It has not responded since an alarm, so nothing was sent."""

    happened: Happened = "no"
