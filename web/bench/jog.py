"""One hold: an axis moves for as long as somebody keeps saying so."""

import asyncio
import contextlib
import secrets
from abc import abstractmethod
from collections.abc import Callable

from ...drivers.client import DeviceClient, Outcome, ServerUnreachable
from ...schemas.messages import Goal
from ...schemas.quantity import UnitError, magnitude_in
from ..guard.refusal import Refusal
from ..models.devices import DEAD_MAN_MS, JogStart, JogState
from .acting import take_lease
from .station import Station

DEAD_MAN_S = DEAD_MAN_MS / 1000
LEASE_S = 3.0
STAND_S = 2.0
"""So long a cancelled move may take to come to rest; then the device is stopped."""


class Jog:
    """A hold from its start to its rest; `session` is the socket that keeps it alive."""

    def __init__(
        self, station: Station, asked: JogStart, by: str, changed: Callable[[str], None]
    ) -> None:
        self.id = secrets.token_urlsafe(9)
        self.station = station
        self.asked = asked
        self.session: str | None = None
        self.over = asyncio.Event()
        self.stopped = asyncio.Event()
        self._by = by
        self._changed = changed
        self._reason = ""
        self._beat_at = asyncio.get_running_loop().time()

    def state(self) -> JogState:
        """As the page is told."""
        return JogState(
            id=self.id, device=self.station.name, axis=self.asked.axis,
            direction=self.asked.direction, moving=not self.over.is_set(), reason=self._reason,
        )  # fmt: skip

    def beat(self) -> None:
        """Somebody still holds the button."""
        self._beat_at = asyncio.get_running_loop().time()

    def end(self, reason: str) -> None:
        """Come to rest."""
        if not self.stopped.is_set():
            self._reason = self._reason or reason
            self.stopped.set()

    async def run(self, begun: asyncio.Future[None]) -> None:
        """Take the lease and move; sets `begun` when the axis is on its way."""
        station = self.station
        try:
            async with station.turn:
                client = station.reached()
                await take_lease(client, station.name, self._by, LEASE_S)
                try:
                    await self.move(client, begun)
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

    @abstractmethod
    async def move(self, client: DeviceClient, begun: asyncio.Future[None]) -> None:
        """Move until `stopped`, or until the device ends it."""

    async def follow(
        self, client: DeviceClient, goal: Goal, begun: asyncio.Future[None]
    ) -> Outcome | None:
        """Send a goal and see to it that it ends with the hold; None where it had to be stopped."""
        self.station.goal = goal.id
        following = asyncio.create_task(client.follow(goal))
        if not begun.done():
            begun.set_result(None)
            # Whoever asked hears of it only now, and begins to say so.
            self._beat_at = asyncio.get_running_loop().time()
        self._changed(self.id)
        try:
            outcome = await self._watch(client, goal, following)
        finally:
            following.cancel()
            await asyncio.gather(following, return_exceptions=True)
        self.station.take_result(outcome.result if outcome is not None else None)
        if outcome is not None and outcome.state != "SUCCEEDED":
            self.end(outcome.error.message if outcome.error else "it was cancelled")
        return outcome

    def feed(self, unit: str, most: float | None) -> float:
        """The feed in the contract's unit; raises Refusal (422) where that is too much."""
        try:
            feed = magnitude_in(f"{self.asked.feed_mm_min!r} mm/min", unit)
        except UnitError as fault:
            raise Refusal(422, "PARAMS", f"feed: {fault}") from fault
        if most is not None and feed > most:
            raise Refusal(422, "PARAMS", f"feed: {most:g} {unit} is the most")
        return feed

    async def _watch(
        self, client: DeviceClient, goal: Goal, following: "asyncio.Task[Outcome]"
    ) -> Outcome | None:
        """Wait for the end of a move, or end it; None where the device had to be stopped."""
        loop = asyncio.get_running_loop()
        stopping = asyncio.create_task(self.stopped.wait())
        try:
            while not following.done() and not self.stopped.is_set():
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
        confirmed, words = (await client.stop(self.station.name, STAND_S))[self.station.name]
        told = "was stopped" if confirmed else f"did not confirm the stop either ({words})"
        self._reason += f"; it did not come to rest and {told}"
        return None
