"""A hold of a device that knows no jog: moves of two seconds at most, one after the other.

So it stops within the dead-man's time when no keep-alive comes, and within one stretch when this
whole server is killed: then nobody is left to cancel, and the device brings to its end what it was
sent.
"""

import asyncio
from collections.abc import Callable

from ...drivers.client import DeviceClient
from ...schemas.messages import Goal
from ...schemas.quantity import magnitude_in
from ..models.devices import JogStart
from .form import Moving
from .jog import Jog
from .station import Station
from .where import where_mm

STRETCH_S = 2.0
NEAR_MM = 0.001


class Stretched(Jog):
    """Moves by the device's action for places."""

    def __init__(
        self, station: Station, moving: Moving, asked: JogStart, by: str,
        changed: Callable[[str], None],
    ) -> None:  # fmt: skip
        super().__init__(station, asked, by, changed)
        self._moving = moving

    async def move(self, client: DeviceClient, begun: asyncio.Future[None]) -> None:
        """Stretch after stretch."""
        number = 0
        while not self.stopped.is_set():
            number += 1
            target = self._target()
            if target is None:
                self.end(f"{self.asked.axis} is at its limit")
                break
            await self.follow(client, self._goal(client, number, target), begun)

    def _target(self) -> float | None:
        """Where the next stretch ends, in mm; None at the end of the axis."""
        asked = self.asked
        low, high = self._moving.ranges_mm[asked.axis]
        here = where_mm(self.station, asked.axis)
        far = here + asked.direction * asked.feed_mm_min / 60 * STRETCH_S
        target = min(max(far, low), high)
        return target if abs(target - here) > NEAR_MM else None

    def _goal(self, client: DeviceClient, number: int, target_mm: float) -> Goal:
        action = self.station.contract.actions[self._moving.action]
        unit = action.param_schemas()[self.asked.axis]["unit"]
        params = {self.asked.axis: magnitude_in(f"{target_mm!r} mm", unit)}
        if self._moving.feed_unit is not None:
            params["feed"] = self.feed(self._moving.feed_unit, self._moving.most_feed)
        return Goal(
            id=f"web-jog-{self.id}-{number}", device=self.station.name, boot=client.boot,
            epoch=client.epoch(self.station.name), action=self._moving.action, params=params,
        )  # fmt: skip
