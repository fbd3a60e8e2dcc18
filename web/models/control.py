"""Control of the bench: one named holder, visible to everybody."""

from pydantic import Field

from .base import ApiModel


class ControlState(ApiModel):
    """The current holder; each command extends `ends_at`."""

    holder: str | None = None
    since: str | None = None
    ends_at: str | None = None
    armed: bool = Field(default=False, description="True: it cannot be taken over now.")


class TakeControl(ApiModel):
    """Take control under a name; taking it from another holder needs a reason, which is logged."""

    name: str = Field(min_length=1, max_length=80)
    reason: str = Field(default="", max_length=500)


class ControlTaken(ApiModel):
    """`lease` goes into `X-Control-Lease` with each command; only the holder gets it."""

    lease: str
    control: ControlState


class AskControl(ApiModel):
    """Ask the holder for control; they see a notice."""

    name: str = Field(min_length=1, max_length=80)
