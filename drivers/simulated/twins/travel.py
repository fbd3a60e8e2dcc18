"""A carriage moving along one line: it may be held, resumed, or stopped for good."""

import time
from collections.abc import Callable

from .axis import Move, Point, plan, to_mm, to_steps
from .carriage import Carriage
from .clock import Clock


class Ride:
    """`hold` and `stop` bring the carriage to a stand along its line; from a hold it goes on.

    `state` is that of the contract: what it does now.
    """

    def __init__(self, clock: Clock, carriage: Carriage) -> None:
        self.clock = clock
        self.carriage = carriage
        self.state = "idle"
        self.feed_mm_per_min = 0.0
        self.hold = False
        self.stop = False

    async def go(
        self,
        end: Point,
        feed: float | None,
        state: str,
        ended: Callable[[], bool],
        tell: Callable[[float], None],
    ) -> bool:
        """Whether it came to the end; `ended` and `stop` keep it from that."""
        self.hold = self.stop = False
        whole = plan(self.carriage.believed_mm, to_mm(to_steps(end)), feed)
        left = whole
        try:
            while True:
                self.state = state
                travelled = await self._travel(left, whole.length, ended, tell)
                self.carriage.steps = to_steps(left.point(travelled))
                if travelled >= left.length:
                    return True
                if self.stop or ended() or not await self._held(ended):
                    return False
                left = plan(self.carriage.believed_mm, whole.end, feed)
        finally:
            self.state, self.feed_mm_per_min = "idle", 0.0

    async def _travel(
        self, move: Move, whole_mm: float, ended: Callable[[], bool], tell: Callable[[float], None]
    ) -> float:
        """Millimetres along the line where it came to stand."""
        t = 0.0
        while t < move.duration_s:
            if ended() or self.stop or self.hold:
                await self.clock.sleep(move.speed_at(t) / move.acceleration)
                return move.braked_at(t)
            pace = min(self.clock.tick_s, move.duration_s - t)
            await self.clock.sleep(pace)
            t += pace
            self.feed_mm_per_min = 60 * move.speed_at(t)
            self.carriage.steps = to_steps(move.point(move.travelled(t)))
            if not self.clock.fast:
                self.carriage.publish()
            left = move.length - move.travelled(t)
            tell(min(1.0, 1 - left / whole_mm) if whole_mm else 1.0)
        return move.length

    async def _held(self, ended: Callable[[], bool]) -> bool:
        """Wait until it may continue; False if it was ended meanwhile."""
        self.state, self.feed_mm_per_min = "hold", 0.0
        self.carriage.publish()
        while self.hold and not (self.stop or ended()):
            await self.clock.sleep(min(self.clock.tick_s, 0.05))
        return not (self.stop or ended())


def lapsed(wanted_at: Callable[[], float], lease_s: float) -> Callable[[], bool]:
    """Whether a jog is no longer held: its goal has not been sent again within the lease."""
    begun = time.monotonic()
    return lambda: time.monotonic() - max(begun, wanted_at()) >= lease_s
