"""A gantry whose controller knows no feed hold: it is given its way in short pieces, just ahead of the axes.

A stop, a hold and the end of this program end the motion where the pieces end that it has: it brakes
along its path, no step is lost, and the position is still trusted.
"""

import asyncio
import contextlib
import math
from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping
from typing import Any, ClassVar

from ...system.tasks import end, keep
from ..driver import ActionFailed, GoalContext, Place
from .bench import LETTERS, Point, place_words
from .faults import Ended, Lost, MotionFault, NotConnected, NotStopped, Refused, Silent, WrongPlace
from .jog_rules import JogRules
from .work_zero import WorkZero

LOOK_S = 0.02
AGAIN_S = 1.0


class FedGantry(JogRules):
    """Feeds moves and jogs, keeps the work zero itself, and reconnects when its controller is back."""

    when_lost: ClassVar[str] = "; it reconnects when it is back"

    piece_s: ClassVar[float] = 0.05
    ahead_s: ClassVar[float] = 0.25
    """How far it is given its way ahead of the axes, beside the way that braking takes."""
    stop_s: ClassVar[float] = 5.0
    """How long a stop waits for it to stand; braking and a quarter of a second are usual."""

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.zero = WorkZero(place.folder)
        self._holding = False
        self._at: Point | None = None
        self._keeper: asyncio.Task[None] | None = None

    async def open(self) -> None:
        try:
            self.zero.read()
            await self._reach()
        except BaseException:  # a cancel as well
            await self._let_go()
            raise
        self._keep()

    async def close(self) -> None:
        await end(self._keeper)
        await self._let_go()

    def _keep(self) -> None:
        self._keeper = keep(f"reconnecting {self._name()}", self._reach_when_lost)

    async def _reach_when_lost(self) -> None:
        while True:
            await asyncio.sleep(AGAIN_S)
            if self.known.lost:
                with contextlib.suppress(OSError):
                    await self._reach_again()

    @abstractmethod
    async def _reach(self) -> None:
        """Connect, and learn what the machine is; raises OSError."""

    @abstractmethod
    async def _let_go(self) -> None:
        """Close the connection."""

    async def _reach_again(self) -> None:
        await self._reach()

    def _locked(self) -> bool:
        return False

    def _place_known(self) -> Point | None:
        return self._at

    def _pins(self) -> str:
        return ""

    @abstractmethod
    async def _piece(self, place: dict[int, float], speed: float) -> None:
        """Give it a straight way to these machine positions (mm, mm/s), and wait until it is taken."""

    @abstractmethod
    async def _finish(self) -> None:
        """Wait for the proof that all motion has ended; raises MotionFault."""

    @abstractmethod
    async def _break_off(self) -> None:
        """Stop at once what cannot be stopped by not feeding it; raises MotionFault."""

    @abstractmethod
    def _fastest(self, way: dict[int, float]) -> tuple[float, float]:
        """The speed (mm/s) and the acceleration (mm/s2) that it can go along a way at most."""

    async def _still(self) -> Point:
        """Where it stands, once all motion has ended."""
        await self._finish()
        machine = await self._machine()
        self._publish(machine)
        return machine

    async def _drive(self, goal: GoalContext, end: dict[int, float], feed: float | None) -> Point:
        with self._moving(goal, "move"):
            start = await self._machine()
            way = {axis: value - start[axis] for axis, value in end.items()}
            await self._feed(goal, start, way, feed, lambda: True)
            return await self._arrived(end)

    async def _jog_by(self, goal: GoalContext, by: dict[int, float], feed: float) -> None:
        with self._moving(goal, "jog"):
            start = await self._machine()
            await self._feed(goal, start, by, feed, lambda: True)
            await self._arrived({axis: start[axis] + distance for axis, distance in by.items()})

    async def _jog_while(
        self, goal: GoalContext, far: dict[int, float], feed: float, held: Callable[[], bool]
    ) -> None:
        with self._moving(goal, "jog"):
            await self._feed(goal, await self._machine(), far, feed, held)
            await self._still()

    async def _feed(
        self, goal: GoalContext, start: Point, way: dict[int, float], feed: float | None,
        wanted: Callable[[], bool],
    ) -> None:  # fmt: skip
        """Give it the way, piece by piece, as long as it is wanted; raises Ended once it stands."""
        clock, ended = asyncio.get_running_loop().time, self._ended(goal)
        length = math.hypot(*way.values())
        speed, acceleration = self._fastest(way)
        speed = min(speed, (feed or math.inf) / 60)
        ahead = speed * self.ahead_s + speed**2 / (2 * acceleration)
        pieces = max(1, math.ceil(length / (speed * self.piece_s))) if length else 0
        begun, given = clock(), 0.0
        for number in range(1, pieces + 1):
            while self._holding or given - _gone(clock() - begun, speed, acceleration) > ahead:
                if ended() or not wanted():
                    break
                await asyncio.sleep(LOOK_S)
                if self._holding:
                    self._check_there()
                    begun, given = clock(), 0.0
            if ended():
                await self._still()
                raise Ended
            if not wanted():
                return
            part = number / pieces
            place = {axis: start[axis] + part * by for axis, by in way.items()}
            try:
                await self._piece(place, speed)
            except Refused as fault:
                if number == 1:
                    raise
                with contextlib.suppress(MotionFault):
                    await self._still()
                raise MotionFault(f"after a part of the way {fault}") from fault
            given += length / pieces
            at = list(start)
            for axis, value in place.items():
                at[axis] = value
            goal.feedback(part, f"on the way to {place_words(self.bench.to_bench(tuple(at)))}")
        while self._holding and not ended():
            self._check_there()
            await asyncio.sleep(LOOK_S)
        if ended():
            await self._still()
            raise Ended

    def _check_there(self) -> None:
        """A resume must not go on with a way that began before its connection or its place was lost."""
        if self.known.lost or not self.homed:
            raise Lost(self.known.lost or self.known.alarm or "its position was lost")

    async def _arrived(self, end: dict[int, float]) -> Point:
        machine = await self._still()
        if self.known.alarm:
            raise MotionFault(self.known.alarm)
        if all(abs(machine[axis] - value) <= self.tolerance for axis, value in end.items()):
            return machine
        found = " ".join(f"{LETTERS[a]} {machine[a]:.3f}" for a in sorted(end))
        wanted = " ".join(f"{LETTERS[a]} {v:.3f}" for a, v in sorted(end.items()))
        raise WrongPlace(
            f"it has stopped, but at {found} instead of {wanted} (machine coordinates)"
        )

    async def _hold(self) -> None:
        self._holding = True
        await self._still()

    async def _resume(self) -> None:
        self._holding = False

    async def _stop(self) -> None:
        """What is fed ends by itself; the rest is broken off."""
        self._holding = False
        if self._doing in ("home", "touch"):
            await self._break_off()
        elif not await self._ends(self.stop_s):
            self.known.homed = False
            await self._break_off()
            if not await self._ends(self.stop_s):
                raise NotStopped(
                    "it did not confirm that it has stopped and may still move: press its emergency stop"
                )
        if self.known.lost:
            raise Lost(f"whether it has stopped is unknown: {self.known.lost}")

    async def _ends(self, seconds: float) -> bool:
        clock = asyncio.get_running_loop().time
        end = clock() + seconds
        while self._doing is not None and clock() < end:  # noqa: ASYNC110 - the motion notices by itself
            await asyncio.sleep(LOOK_S)
        return self._doing is None

    @contextlib.contextmanager
    def _moving(self, goal: GoalContext, doing: str) -> Iterator[None]:
        """Wrap one motion: a stop or a cancel that ends it is reported as such."""
        self._holding = False
        error = "HomingFailed" if doing == "home" else "Alarm"
        try:
            with self._under_way(doing):
                yield
        except Ended:
            raise self._ending(goal, error, "yes") from None
        except (Lost, NotConnected) as fault:  # the way that it was given before is gone, too
            raise Lost(f"{fault}. It may finish what it was given; home it") from fault
        except Silent:
            self.known.homed = False
            raise

    async def _set_zero(self, axes: list[int]) -> None:
        try:
            self.zero.set(axes, await self._machine())
        except OSError as fault:
            raise ActionFailed("Offline", f"{self._name()}: {fault}", "no") from fault

    def _offset(self) -> Point | None:
        machine = self._place_known()
        return None if machine is None else self.zero.place(len(machine))

    def _held_in(self) -> str:
        return ""

    def _state(self) -> str:
        """The contract's `state`."""
        if self.known.lost:
            return "offline"
        if self._doing == "home":
            return "homing"
        if self.known.alarm:
            return "alarm"
        if self._doing:
            return "hold" if self._holding else "moving"
        return "idle"

    async def status(self) -> dict[str, Any]:
        machine, zero = self._place_known(), self._offset()
        told: dict[str, Any] = {
            "state": self._state(),
            "homed": self.homed,
            "alarm": self.known.lost or self.known.alarm,
        }
        if machine is not None and zero is not None:
            self._publish(machine)
            work = tuple(at - from_ for at, from_ in zip(machine, zero, strict=True))
            told |= self._standing(machine, work) | self._more_status(machine)
        return told


def fastest(
    way: Mapping[int, float], axes: Mapping[int, tuple[float, float]]
) -> tuple[float, float] | None:
    """Speed and acceleration along a way that no axis exceeds; None if none of these axes moves."""
    length = math.hypot(*way.values())
    parts = [(axes[axis], abs(by) / length) for axis, by in way.items() if by and axis in axes]
    if not parts:
        return None
    return (
        min(speed / part for (speed, _), part in parts),
        min(acceleration / part for (_, acceleration), part in parts),
    )


def _gone(seconds: float, speed: float, acceleration: float) -> float:
    """How far it has gone since it began, from standstill."""
    ramp = speed / acceleration
    if seconds < ramp:
        return acceleration * seconds**2 / 2
    return speed * (seconds - ramp / 2)
