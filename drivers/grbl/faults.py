"""How a controller fails to do what it was asked."""

from ...schemas.contract import Happened
from .words import alarm_words, error_words


class GrblFault(Exception):
    """`error` is the contract's name for it, `happened` whether what was asked took effect."""

    error = "Alarm"
    happened: Happened = "unknown"


class Refused(GrblFault):
    """`error:N`: the line was not taken."""

    happened: Happened = "no"

    def __init__(self, code: int) -> None:
        super().__init__(f"it answered {error_words(code)}")
        self.code = code
        self.error = "SoftLimit" if code == 15 else "Alarm"


class Alarmed(GrblFault):
    """`ALARM:N` while a line was under way."""

    def __init__(self, code: int) -> None:
        super().__init__(f"it answered {alarm_words(code)}")
        self.code = code


class Restarted(GrblFault):
    """A boot: whatever was under way is gone."""


class Silent(GrblFault):
    """No answer in time."""


class StillLocked(GrblFault):
    """It answers nothing since an alarm, so nothing was asked of it."""

    happened: Happened = "no"


class Lost(GrblFault):
    """The port is gone."""


class NotConnected(GrblFault):
    """The port was gone before anything was asked."""

    error = "Offline"
    happened: Happened = "no"
