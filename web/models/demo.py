"""Injected faults, on the simulated lab of `labrun web --demo`."""

from typing import Literal

from pydantic import Field

from .base import ApiModel

FaultKind = Literal["error", "kill", "freeze", "thaw", "interlock", "stop", "slow", "clear"]


class OrderFault(ApiModel):
    """`error`: the next `count` goals of the action fail; `kill`: its server dies, and is started again.

    Until `clear`: `freeze`, its server is silent, as behind a pulled cable; `interlock`, its enclosure is
    open; `stop`, its safe state is not confirmed; `slow`, all takes 20 times as long. `thaw` ends a `freeze`.
    """

    device: str
    kind: FaultKind = "error"
    action: str | None = None
    error: str | None = Field(
        default=None, description="An error name of the contract; any if null."
    )
    count: int = Field(default=1, ge=1, le=10_000)


class OrderedFault(ApiModel):
    """A fault that is still to come, or lasts."""

    kind: FaultKind
    text: str


class DeviceFaults(ApiModel):
    """What can be requested of a device, and what was."""

    kinds: list[FaultKind]
    errors: dict[str, list[str]] = Field(description="By action, the errors that it can end with.")
    ordered: list[OrderedFault]
