"""One hold: an axis moves for as long as somebody keeps saying so, and never on its own for long.

It moves in stretches of two seconds at most. So it stops within the dead-man's time when no
keep-alive comes, and within one stretch when this whole server is killed: then nobody is left to
cancel, and the device brings to its end what it was sent.
"""

import asyncio
import contextlib
import secrets
from collections.abc import Callable

from ...drivers.client import DeviceClient, Outcome, ServerUnreachable
from ...schemas.messages import Goal
from ...schemas.quantity import magnitude_in
from ..guard.refusal import Refusal
from ..models.devices import DEAD_MAN_MS, JogStart, JogState
from .acting import take_lease
from .form import Moving
from .station import Station
from .where import where_mm

DEAD_MAN_S = DEAD_MAN_MS / 1000
STRETCH_S = 2.0
NEAR_MM = 0.001
LEASE_S = 3.0
STAND_S = 2.0
"""So long a cancelled move may take to come to rest; then the device is stopped."""


class Jog:
    """A hold from its start to its rest; `session` is the socket that keeps it alive."""

    def __init__(
        self, station: Station, moving: Moving, asked: JogStart, by: str,
        changed: Callable[[str], None],
    ) -> None:  # fmt: skip
        self.id = secrets.token_urlsafe(9)
        self.station = station
        self.session: str | None = None
        self.over = asyncio.Event()
        self._moving = moving
        self._asked = asked
        self._by = by
        self._changed = changed
        self._reason = ""
        self._stop = asyncio.Event()
        self._beat_at = asyncio.get_running_loop().time()

    def state(self) -> JogState:
        """As the page is told."""
        return JogState(
            id=self.id, device=self.station.name, axis=self._asked.axis,
            direction=self._asked.direction, moving=not self.over.is_set(), reason=self._reason,
        )  # fmt: skip

    def beat(self) -> None:
        """Somebody still holds the button."""
        self._beat_at = asyncio.get_running_loop().time()

    def end(self, reason: str) -> None:
        """Come to rest."""
        if not self._stop.is_set():
            self._reason = self._reason or reason
            self._stop.set()

    async def run(self, begun: asyncio.Future[None]) -> None:
        """Take the lease and move; sets `begun` when the first stretch is under way."""
        station = self.station
        try:
            async with station.turn:
                client = station.reached()
                await take_lease(client, station.name, self._by, LEASE_S)
                try:
                    await self._stretches(client, begun)
                finally:
                    station.goal = None
                    await client.release(station.name)
        except Refusal as refusal:
            if not begun.done():
                raise
            self.end(str(refusal))
        finally:
            self.over.set()
            self._changed(self.id)

    async def _stretches(self, client: DeviceClient, begun: asyncio.Future[None]) -> None:
        number = 0
        while not self._stop.is_set():
            number += 1
            target = self._target()
            if target is None:
                self.end(f"{self._asked.axis} is at its limit")
                break
            goal = self._goal(client, number, target)
            self.station.goal = goal.id
            following = asyncio.create_task(client.follow(goal))
            if not begun.done():
                begun.set_result(None)
            self._changed(self.id)
            try:
                outcome = await self._watch(client, goal, following)
            finally:
                following.cancel()
                await asyncio.gather(following, return_exceptions=True)
            self.station.take_result(outcome.result if outcome is not None else None)
            if outcome is not None and outcome.state != "SUCCEEDED":
                self.end(outcome.error.message if outcome.error else "it was cancelled")

    async def _watch(
        self, client: DeviceClient, goal: Goal, following: "asyncio.Task[Outcome]"
    ) -> Outcome | None:
        """Wait for the end of a stretch, or end it; None where the device had to be stopped."""
        loop = asyncio.get_running_loop()
        stopping = asyncio.create_task(self._stop.wait())
        try:
            while not following.done() and not self._stop.is_set():
                left = self._beat_at + DEAD_MAN_S - loop.time()
                if left <= 0:
                    self.end(f"no keep-alive for {DEAD_MAN_MS} ms")
                    break
                await asyncio.wait(
                    {following, stopping}, timeout=left, return_when=asyncio.FIRST_COMPLETED
                )
        finally:
            stopping.cancel()
            await asyncio.gather(stopping, return_exceptions=True)
        if following.done():
            return following.result()
        with contextlib.suppress(ServerUnreachable):
            await client.cancel(goal.id)
        await asyncio.wait({following}, timeout=STAND_S)
        if following.done():
            return following.result()
        await client.stop(self.station.name, STAND_S)
        self._reason += "; it did not come to rest and was stopped"
        return None

    def _target(self) -> float | None:
        """Where the next stretch ends, in mm; None at the end of the axis."""
        asked = self._asked
        low, high = self._moving.ranges_mm[asked.axis]
        here = where_mm(self.station, asked.axis)
        far = here + asked.direction * asked.feed_mm_min / 60 * STRETCH_S
        target = min(max(far, low), high)
        return target if abs(target - here) > NEAR_MM else None

    def _goal(self, client: DeviceClient, number: int, target_mm: float) -> Goal:
        action = self.station.contract.actions[self._moving.action]
        unit = action.param_schemas()[self._asked.axis]["unit"]
        params = {self._asked.axis: magnitude_in(f"{target_mm!r} mm", unit)}
        if self._moving.feed_unit is not None:
            feed = magnitude_in(f"{self._asked.feed_mm_min!r} mm/min", self._moving.feed_unit)
            if self._moving.most_feed is not None and feed > self._moving.most_feed:
                raise Refusal(
                    422, "PARAMS",
                    f"feed: {self._moving.most_feed:g} {self._moving.feed_unit} is the most",
                )  # fmt: skip
            params["feed"] = feed
        return Goal(
            id=f"web-jog-{self.id}-{number}", device=self.station.name, boot=client.boot,
            epoch=client.epoch(self.station.name), action=self._moving.action, params=params,
        )  # fmt: skip
