"""A simulated messenger: tells nobody, and remembers what it would have said.

Configuration: `to` (names; what stands beside them is not used). Without it, anybody can be told.
"""

from typing import Any, ClassVar

from ..driver import GoalContext, Place
from ..messenger.messenger import named
from .twins.twin import Twin

SEND_S = 1.0


class SimMessenger(Twin):
    """Implements messenger@1."""

    contract: ClassVar[str] = "messenger@1"
    options: ClassVar[tuple[str, ...]] = ("to",)

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.to: dict[str, str] = self.config.get("to") or {}

    async def status(self) -> dict[str, Any]:
        return {"receivers": list(self.to)}

    async def send(
        self, goal: GoalContext, *, text: str, title: str = "", to: list[str] | None = None,
        picture: str | None = None,
    ) -> dict[str, Any]:  # fmt: skip
        told = list(named(self.to, to)) if self.to else (to or ["everybody"])
        with self.failing("send", goal):
            await self.clock.sleep(SEND_S)
            self.truth.append("send", goal=goal.id, text=text, title=title, told=told)
        return {"told": told}

    async def last_send(self, goal: GoalContext) -> dict[str, Any]:
        newest = self.truth.entry(len(self.truth))
        return {"goal_id": newest["goal"], "told": newest["told"]} if newest else {"goal_id": ""}
