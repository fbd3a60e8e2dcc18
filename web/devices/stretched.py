"""A hold on a device without `jog`: moves of at most two seconds, one after the other.

So it stops within the dead-man time if no keep-alive comes, and within one stretch if this server
is killed: then nothing is left to cancel the move, and the device completes it.
"""

import asyncio
from collections.abc import Callable

from ...drivers.client.client import DeviceClient
from ...schemas.messages import Goal
from ...schemas.quantity import magnitude_in
from ..models.devices import JogStart
from .device_link import DeviceLink
from .form import Moving
from .jog import Jog
from .where import where_mm

STRETCH_S = 2.0
NEAR_MM = 0.001


class Stretched(Jog):
    """Moves with the device's positioning action."""

    def __init__(
        self, device_link: DeviceLink, moving: Moving, asked: JogStart, by: str,
        changed: Callable[[str], None],
    ) -> None:  # fmt: skip
        super().__init__(device_link, asked, by, changed)
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
        here = where_mm(self.device_link, asked.axis)
        far = here + asked.direction * asked.feed_mm_min / 60 * STRETCH_S
        target = min(max(far, low), high)
        return target if abs(target - here) > NEAR_MM else None

    def _goal(self, client: DeviceClient, number: int, target_mm: float) -> Goal:
        action = self.device_link.contract.actions[self._moving.action]
        unit = action.param_schemas()[self.asked.axis]["unit"]
        params = {self.asked.axis: magnitude_in(f"{target_mm!r} mm", unit)}
        if self._moving.feed_unit is not None:
            params["feed"] = self.feed(self._moving.feed_unit, self._moving.most_feed)
        return Goal(
            id=f"web-jog-{self.id}-{number}", device=self.device_link.name, boot=client.boot,
            epoch=client.epoch(self.device_link.name), action=self._moving.action, params=params,
        )  # fmt: skip
