"""The ways in which a controller fails a request."""

from ...schemas.contract import Happened
from .messages import alarm_words, error_words


class GrblFault(Exception):
    """`error` is the contract's name for it, `happened` whether the request took effect."""

    error = "Alarm"
    happened: Happened = "unknown"


class Refused(GrblFault):
    """`error:N`: the line was not accepted."""

    happened: Happened = "no"

    def __init__(self, code: int) -> None:
        super().__init__(f"it answered {error_words(code)}")
        self.code = code
        self.error = "SoftLimit" if code == 15 else "Alarm"


class Alarmed(GrblFault):
    """`ALARM:N` while a line was being executed."""

    def __init__(self, code: int) -> None:
        super().__init__(f"it answered {alarm_words(code)}")
        self.code = code


class Restarted(GrblFault):
    """A boot: whatever was running is lost."""


class Silent(GrblFault):
    """No answer in time."""


class StillLocked(GrblFault):
    """It has not responded since an alarm, so nothing was sent."""

    happened: Happened = "no"


class Lost(GrblFault):
    """The port is gone."""


class NotConnected(GrblFault):
    """The port was gone before anything was sent."""

    error = "Offline"
    happened: Happened = "no"
