"""The ways in which what moves the axes fails a request, whatever it is."""

from ...schemas.contract import Happened

STOPPED = (
    "it is stopped: repeat the move, and switch the controller off and on if that does not help"
)
"""What to do with a move whose end was never told, behind the reason."""


class MotionFault(Exception):
    """`error` is the contract's name for it, `happened` whether the request took effect."""

    error = "Alarm"
    happened: Happened = "unknown"


class Refused(MotionFault):
    """What was sent was not accepted."""

    happened: Happened = "no"


class NotThere(Refused):
    """It has nothing that does what it was asked."""

    error = "NotAvailable"


class Restarted(MotionFault):
    """A boot: whatever was running is lost."""


class Silent(MotionFault):
    """No answer in time."""


class Lost(MotionFault):
    """The port or the connection is gone."""


class NotConnected(MotionFault):
    """It was gone before anything was sent."""

    error = "Offline"
    happened: Happened = "no"


class WrongPlace(MotionFault):
    """It stopped at another position than the target."""

    error = "WrongPlace"
    happened: Happened = "yes"


class HomingFailed(MotionFault):
    """Its position is unknown."""

    error = "HomingFailed"

    @classmethod
    def too_long(cls, seconds: float) -> "HomingFailed":
        """It was stopped because its time was up."""
        return cls(
            f"it did not end within {seconds:g} s and was reset; is a switch cable off, or "
            f"`homing_timeout` too short for this machine?"
        )


class NotStopped(MotionFault):
    """The worst answer that a stop can give."""


class Ended(Exception):
    """The motion was ended early, and the axes have stopped."""
