"""Injected faults, on the simulated lab of `labrun web --demo`."""

from typing import Literal

from pydantic import Field

from .base import ApiModel


class OrderFault(ApiModel):
    """`error`: the next `count` goals of the action fail. The others act on the server process."""

    device: str
    kind: Literal["error", "kill", "freeze", "thaw", "clear"] = "error"
    action: str | None = None
    error: str | None = Field(
        default=None, description="An error name of the contract; any if null."
    )
    count: int = Field(default=1, ge=1, le=10_000)
