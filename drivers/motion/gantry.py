"""What every gantry does alike, real or simulated: the actions of gantry@2 as they are called."""

from abc import abstractmethod
from typing import Any, ClassVar

from ..driver import ActionFailed, Driver, GoalContext, Place
from .outputs import Output, read_outputs

AXES = "xyzabc"


def jog_way(axis: str | None, direction: str | None, way: str | None) -> dict[str, int]:
    """The axes that a jog moves and their directions, 1 or -1; raises Rejected where one is named twice."""
    written = way or f"{direction or '+'}{axis}"
    signs = {
        letter: 1 if sign == "+" else -1
        for sign, letter in zip(written[::2], written[1::2], strict=True)
    }
    if len(signs) < len(written) // 2:
        raise ActionFailed("Rejected", f"way {written!r} names an axis twice", "no")
    return signs


class AnyGantry(Driver):
    """Says which axes a motion moves, and which output is switched; how that is done is not here."""

    contract: ClassVar[str] = "gantry@2"

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.outputs: dict[str, Output] = read_outputs(place.config)
        self.on: set[str] = set()
        """The outputs that are on, as far as is known."""
        self.by_hand: dict[str, Any] = {"goal_id": None}
        """The last motion or zero that a person has asked for."""

    @abstractmethod
    async def _travel(
        self, goal: GoalContext, wanted: dict[str, float], feed: float | None, safe_z: float | None
    ) -> dict[str, Any]:
        """Move these axes to these places; with `safe_z` at that height."""

    @abstractmethod
    async def _switch(self, goal: GoalContext, output: str, on: bool, power: float) -> None:
        """Switch an output that there is; `power` in percent."""

    async def move_to(
        self,
        goal: GoalContext,
        *,
        x: float | None = None,
        y: float | None = None,
        z: float | None = None,
        a: float | None = None,
        b: float | None = None,
        c: float | None = None,
        feed: float | None = None,
        safe_z: float | None = None,
    ) -> dict[str, Any]:
        given = zip(AXES, (x, y, z, a, b, c), strict=True)
        wanted = {axis: float(value) for axis, value in given if value is not None}
        height = self.place.config.get("safe_z") if safe_z is None else safe_z
        return await self._travel(goal, wanted, feed, height)

    async def set_output(
        self, goal: GoalContext, *, output: str, on: bool, power: float = 100.0
    ) -> dict[str, Any]:
        if output not in self.outputs:
            there = ", ".join(self.outputs) or "none; `outputs` in its config names them"
            words = f"{self._name()} has no output {output}; it has {there}"
            raise ActionFailed("NotAvailable", words, "no")
        await self._switch(goal, output, on, power)
        return {}

    async def last_by_hand(self, goal: GoalContext) -> dict[str, Any]:
        return self.by_hand

    def _name(self) -> str:
        """The device's name in messages."""
        return self.place.device
