"""A hold on a device with its own `jog`: one goal, sent again with each keep-alive.

The device itself is the dead-man's switch: it stops the axis if the goal is not repeated within
the lease, even if this server is killed, hangs, or loses its connection. This server only passes
on keep-alives from a browser; it never sends one by itself.
"""

import asyncio
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ...drivers.client.client import DeviceClient, ServerUnreachable
from ...schemas.contract import Contract
from ...schemas.messages import Goal
from ...schemas.quantity import magnitude_in, same_dimension
from ...system.tasks import end, spawn
from ..models.devices import Axis, JogStart
from .device_link import DeviceLink
from .jog import Jog

JOG = "jog"
SIGNS = {1: "+", -1: "-"}


def way_words(signs: Mapping[Axis, int]) -> str:
    """Axes and directions as a device's `jog` takes them: `+x-y`."""
    return "".join(f"{SIGNS[sign]}{axis}" for axis, sign in signs.items())


@dataclass(frozen=True, slots=True)
class OwnJog:
    """The action `jog` of a device: its axes and its units."""

    axes: tuple[str, ...]
    feed_unit: str
    most_feed: float | None
    lease_unit: str
    several: bool
    """Whether it moves several axes at once, by `way`."""


def jogging_of(contract: Contract, offered: Mapping[str, Any]) -> OwnJog | None:
    """The `jog` action of a device, if both our contract and its server's contract have it.

    `offered` is the contract as the server describes it. The action takes `axis`, `direction`
    (`+` or `-`), `feed` and `lease` (gantry@1 says what they mean), perhaps `way` (gantry@2), and
    can be cancelled.
    """
    action = contract.actions.get(JOG)
    if action is None or not action.cancel or JOG not in offered.get("actions", {}):
        return None
    properties = action.params.get("properties", {})
    axes = properties.get("axis", {}).get("enum", [])
    signs = properties.get("direction", {}).get("enum", [])
    feed, lease = properties.get("feed", {}), properties.get("lease", {})
    if not axes or not set(SIGNS.values()) <= set(signs) or not feed.get("unit"):
        return None
    if not lease.get("unit") or not same_dimension(lease["unit"], "s"):
        return None
    return OwnJog(
        tuple(axes), feed["unit"], feed.get("maximum"), lease["unit"], "way" in properties
    )


def jogging_by_itself(device_link: DeviceLink, axis: Axis) -> OwnJog | None:
    """The same for a connected device and one axis."""
    described = (
        device_link.client.devices.get(device_link.name) if device_link.client is not None else None
    )
    found = jogging_of(device_link.contract, described.contract) if described is not None else None
    return found if found is not None and axis in found.axes else None


class Held(Jog):
    """Moves by the device's own `jog`."""

    def __init__(
        self, device_link: DeviceLink, jogging: OwnJog, asked: JogStart, by: str,
        changed: Callable[[str], None],
    ) -> None:  # fmt: skip
        super().__init__(device_link, asked, by, changed)
        self._jogging = jogging
        self._fresh = asyncio.Event()
        self._passed_at = 0.0

    def beat(self) -> None:
        """Pass it on."""
        super().beat()
        self._fresh.set()

    async def move(self, client: DeviceClient, begun: asyncio.Future[None]) -> None:
        """One goal, from sending to its end."""
        goal = self._goal(client)
        self._fresh.clear()
        self._passed_at = asyncio.get_running_loop().time()
        keeping = spawn(f"pass on the keep-alives of hold {self.id}", self._keep(client, goal))
        try:
            await self.follow(client, goal, begun)
            silent = asyncio.get_running_loop().time() - self._passed_at > self.dead_man_s
            axes = " or ".join((self.asked.axis, *self.asked.along))
            self.end("no keep-alive reached the device" if silent else f"{axes} is at its limit")
        finally:
            await end(keeping)

    async def _keep(self, client: DeviceClient, goal: Goal) -> None:
        """Send the goal again for each keep-alive of the browser, until it has ended."""
        while True:
            await self._fresh.wait()
            self._fresh.clear()
            try:
                if not await client.keep(goal):
                    return
                self._passed_at = asyncio.get_running_loop().time()
            except ServerUnreachable as fault:
                self.end(str(fault))  # the device stops by itself: it no longer gets keep-alives
                return

    def _goal(self, client: DeviceClient) -> Goal:
        asked = self.asked
        params: dict[str, Any] = (
            {"way": way_words({asked.axis: asked.direction, **asked.along})}
            if asked.along
            else {"axis": asked.axis, "direction": SIGNS[asked.direction]}
        )
        params |= {
            "feed": self.feed(self._jogging.feed_unit, self._jogging.most_feed),
            "lease": magnitude_in(f"{self.dead_man_s} s", self._jogging.lease_unit),
        }
        return Goal(
            id=f"web-jog-{self.id}", device=self.device_link.name, boot=client.boot,
            epoch=client.epoch(self.device_link.name), action=JOG, params=params,
        )  # fmt: skip
