"""One hold: an axis moves for as long as keep-alives come."""

import asyncio
import contextlib
import secrets
from abc import abstractmethod
from collections.abc import Callable

from ...drivers.client.client import DeviceClient, Outcome, ServerUnreachable
from ...schemas.messages import Goal
from ...schemas.quantity import UnitError, magnitude_in
from ...system.tasks import end, first_of, spawn
from ..local.refusal import Refusal
from ..models.devices import JogStart, JogState
from .acting import take_lease
from .device_link import DeviceLink

LEASE_S = 3.0
STAND_S = 2.0
"""Time for a cancelled move to come to rest; after that the device is stopped."""


class Jog:
    """A hold from its start to its rest; `session` is the socket that keeps it alive."""

    def __init__(
        self, device_link: DeviceLink, asked: JogStart, by: str, changed: Callable[[str], None]
    ) -> None:
        self.id = secrets.token_urlsafe(9)
        self.device_link = device_link
        self.asked = asked
        self.session: str | None = None
        self.over = asyncio.Event()
        self.stopped = asyncio.Event()
        self._by = by
        self._changed = changed
        self._reason = ""
        self._beat_at = asyncio.get_running_loop().time()
        self.dead_man_s = asked.dead_man_ms / 1000

    def state(self) -> JogState:
        """As sent to the page."""
        return JogState(
            id=self.id, device=self.device_link.name, axis=self.asked.axis,
            direction=self.asked.direction, moving=not self.over.is_set(), reason=self._reason,
            dead_man_ms=self.asked.dead_man_ms,
        )  # fmt: skip

    def beat(self) -> None:
        """Keep-alive: the button is still held."""
        self._beat_at = asyncio.get_running_loop().time()

    def end(self, reason: str) -> None:
        """Come to rest."""
        if not self.stopped.is_set():
            self._reason = self._reason or reason
            self.stopped.set()

    async def run(self, begun: asyncio.Future[None]) -> None:
        """Take the lease and move, in a turn that ends here; sets `begun` when the axis is moving."""
        device_link = self.device_link
        try:
            client = device_link.reachable_client()
            await take_lease(client, device_link.name, self._by, LEASE_S)
            try:
                await self.move(client, begun)
            finally:
                device_link.leave_turn()
                await client.release(device_link.name)
        except Refusal as refusal:
            if not begun.done():
                raise
            self.end(str(refusal))
        finally:
            device_link.end_turn()
            self.over.set()
            self._changed(self.id)

    @abstractmethod
    async def move(self, client: DeviceClient, begun: asyncio.Future[None]) -> None:
        """Move until `stopped`, or until the device ends it."""

    async def follow(
        self, client: DeviceClient, goal: Goal, begun: asyncio.Future[None]
    ) -> Outcome | None:
        """Send a goal that ends with the hold; None if the device had to be stopped."""
        self.device_link.goal = goal.id
        following = spawn(f"follow {goal.id}", client.follow(goal))
        if not begun.done():
            begun.set_result(None)
            # The requester learns of it only now, and starts sending keep-alives.
            self._beat_at = asyncio.get_running_loop().time()
        self._changed(self.id)
        try:
            outcome = await self._watch(client, goal, following)
        finally:
            await end(following)
        self.device_link.take_result(outcome.result if outcome is not None else None)
        if outcome is not None and outcome.state != "SUCCEEDED":
            self.end(outcome.error.message if outcome.error else "it was cancelled")
        return outcome

    def feed(self, unit: str, most: float | None) -> float:
        """The feed in the contract's unit; raises Refusal (422) if it is too high."""
        try:
            feed = magnitude_in(f"{self.asked.feed_mm_min!r} mm/min", unit)
        except UnitError as fault:
            raise Refusal(422, "PARAMS", f"feed: {fault}") from fault
        if most is not None and feed > most:
            raise Refusal(422, "PARAMS", f"feed: at most {most:g} {unit}")
        return feed

    async def _watch(
        self, client: DeviceClient, goal: Goal, following: "asyncio.Task[Outcome]"
    ) -> Outcome | None:
        """Wait for the end of a move, or end it; None if the device had to be stopped."""
        loop = asyncio.get_running_loop()
        stopping = spawn(f"wait until hold {self.id} is let go", self.stopped.wait())
        try:
            while not following.done() and not self.stopped.is_set():
                left = self._beat_at + self.dead_man_s - loop.time()
                if left <= 0:
                    self.end(f"no keep-alive for {self.asked.dead_man_ms} ms")
                    break
                await first_of((following, stopping), left)
        finally:
            await end(stopping)
        if not following.done():
            with contextlib.suppress(ServerUnreachable):
                await client.cancel(goal.id)
            await asyncio.wait({following}, timeout=STAND_S)
        if following.done():
            return following.result()
        name = self.device_link.name
        confirmed, words = (await client.stop(name, STAND_S))[name]
        told = "was stopped" if confirmed else f"did not confirm the stop either ({words})"
        self._reason += f"; it did not come to rest and {told}"
        return None
