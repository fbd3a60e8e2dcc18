"""Faults to order, on the simulated lab of `labrun web --demo`."""

from typing import Literal

from pydantic import Field

from .told import Told


class OrderFault(Told):
    """`error`: the next `count` goals of the action end so. The others act on the server process."""

    device: str
    kind: Literal["error", "kill", "freeze", "thaw", "clear"] = "error"
    action: str | None = None
    error: str | None = Field(default=None, description="A name of the contract; any if null.")
    count: int = Field(default=1, ge=1, le=10_000)
