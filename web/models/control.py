"""Who has control of the bench: one holder with a name, seen by everybody."""

from pydantic import Field

from .told import Told


class ControlState(Told):
    """The holder now; `ends_at` moves on with each command."""

    holder: str | None = None
    since: str | None = None
    ends_at: str | None = None
    armed: bool = Field(default=False, description="True: it cannot be taken over now.")


class TakeControl(Told):
    """Take control under a name; taking it from somebody needs a reason, which is logged."""

    name: str = Field(min_length=1, max_length=80)
    reason: str = Field(default="", max_length=500)


class ControlTaken(Told):
    """`lease` goes into `X-Control-Lease` with each command; nobody else is told it."""

    lease: str
    control: ControlState


class AskControl(Told):
    """Ask whoever has control for it; they see a notice."""

    name: str = Field(min_length=1, max_length=80)
