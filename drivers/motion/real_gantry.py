"""What every real gantry shares, whatever moves its axes: ranges, positions, messages."""

import math
import re
from abc import abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, ClassVar, Protocol

from ...schemas.contract import Happened
from ..driver import ActionCanceled, ActionFailed, GoalContext, Place
from ..world import World
from .bench import LETTERS, Bench, Point, place_words, read_bench, unit, whole_limits
from .config import check_config
from .faults import MotionFault, NotConnected, Refused
from .gantry import AXES, AnyGantry
from .legs import legs

TOLERANCE_MM = 0.006
"""Where a machine does not say how fine its steps are."""

HAND_RANGE = ((float("-inf"), float("inf")),) * 3
"""Of a machine that has not told its ranges yet."""


class Known(Protocol):
    """What is known of a controller, whatever carries its lines.

    `homed`: its position is trusted; `alarm`: the alarm that it has to be homed or unlocked after;
    `lost`: why nothing can be sent. Both are empty if there is nothing.
    """

    @property
    def homed(self) -> bool: ...

    @homed.setter
    def homed(self, known: bool) -> None: ...

    @property
    def alarm(self) -> str: ...

    @property
    def lost(self) -> str: ...


class RealGantry(AnyGantry):
    """The part of gantry@2 that is the same for every machine."""

    options: ClassVar[tuple[str, ...]] = ()
    when_lost: ClassVar[str] = ""
    known: Known

    def __init__(self, place: Place) -> None:
        check_config(place.config, self.options)
        super().__init__(place)
        self.limits = whole_limits(place)
        self.bench: Bench = read_bench(place.config, self.limits, HAND_RANGE)
        self.full_power, self.tolerance = 1000.0, TOLERANCE_MM
        self.world = place.in_memory or World(place.world)
        self._published: Point | None = None
        self._doing: str | None = None
        self._stopped = False

    @property
    def homed(self) -> bool:
        """Whether the position is trusted."""
        return self.known.homed

    @abstractmethod
    async def _home(self, goal: GoalContext) -> None:
        """Find the machine's zero; raises MotionFault."""

    @abstractmethod
    async def _hold(self) -> None:
        """Brake the move under way, which `_resume` continues; raises MotionFault."""

    @abstractmethod
    async def _resume(self) -> None:
        """Continue from a hold; raises MotionFault."""

    async def _runs(self) -> bool:
        """Whether it makes a move that can be held and is none of ours, or one that we lost sight of."""
        return False

    @abstractmethod
    async def _stop(self) -> None:
        """Stop the axes, with nothing queued; raises MotionFault."""

    @abstractmethod
    async def _look(self) -> Point | None:
        """Query its state, if it has to be queried; raises MotionFault.

        Returns the machine position if the answer tells it, so that it need not be asked for.
        """

    @abstractmethod
    def _locked(self) -> bool:
        """Whether the controller accepts no motion until it is homed or unlocked."""

    @abstractmethod
    def _held_in(self) -> str:
        """The state that it has to be resumed or halted in; empty if there is none."""

    @abstractmethod
    def _place_known(self) -> Point | None:
        """The machine position that it reported last."""

    @abstractmethod
    async def _machine(self) -> Point:
        """Its current position, freshly queried; raises MotionFault."""

    @abstractmethod
    def _offset(self) -> Point | None:
        """The work zero in machine coordinates; None while unknown."""

    @abstractmethod
    async def _drive(self, goal: GoalContext, end: dict[int, float], feed: float | None) -> Point:
        """Make a move, prove that it ended, and verify it: `end` by machine axis, in mm."""

    @abstractmethod
    async def _set_zero(self, axes: list[int]) -> None:
        """Make the position of these machine axes the work zero, and know the new offset."""

    @abstractmethod
    async def _probe(self, goal: GoalContext, axis: int, way: float, feed: float) -> Point | None:
        """Move a machine axis until the probe touches; where, in machine coordinates, or None."""

    @abstractmethod
    def _move_line(self, end: dict[int, float], feed: float | None) -> str:
        """The command for a straight move in machine coordinates, whatever work zero is set."""

    @abstractmethod
    def _touch_line(self, axis: int, way: float, feed: float) -> str:
        """The command for a touch along a machine axis, from here."""

    @abstractmethod
    async def _override(self, feed: int | None, rapid: int | None) -> None:
        """Set these in percent, and wait until they are reported; raises MotionFault."""

    @abstractmethod
    async def _carry_out(self, line: str) -> None:
        """Send a line that moves nothing, and wait until it was carried out; raises MotionFault."""

    @abstractmethod
    def _pins(self) -> str:
        """The letters of the inputs that it reported as engaged."""

    @abstractmethod
    def _overrides(self) -> tuple[int, ...]:
        """Feed and rapid override in percent, as reported last; empty if not yet."""

    async def safe(self) -> None:
        self._stopped = True
        try:
            await self._stop()
            await self._outputs_off()
        except MotionFault as fault:
            raise OSError(f"{self._name()}: {fault}") from fault

    async def home(self, goal: GoalContext) -> dict[str, Any]:
        self._check_connected("home")
        try:
            await self._home(goal)
        except MotionFault as fault:
            error = "Offline" if isinstance(fault, NotConnected) else "HomingFailed"
            message = f"{self._name()} was asked to home; {fault}"
            raise ActionFailed(error, message, fault.happened) from fault
        return {}

    async def hold(self, goal: GoalContext) -> dict[str, Any]:
        self._check_connected("hold")
        with self._telling("hold"):
            if self._doing == "move" or (self._doing is None and await self._runs()):
                await self._hold()
            elif self._doing is not None:  # homing, a jog, a touch cannot be gone on with: they end
                self._stopped = True
                await self._stop()
        return {}

    async def resume(self, goal: GoalContext) -> dict[str, Any]:
        self._check_connected("resume")
        with self._telling("resume"):
            await self._resume()
        return {}

    async def halt(self, goal: GoalContext) -> dict[str, Any]:
        self._check_connected("halt")
        self._stopped = True
        with self._telling("halt"):
            await self._stop()
            await self._outputs_off()
        return {}

    async def touch(
        self, goal: GoalContext, *, to: float, axis: str = "z", feed: float = 60.0
    ) -> dict[str, Any]:
        self.bench.check_range({axis: float(to)}, self._name())
        self._check_feed(feed)
        start = await self._ready()
        self._check_homed("touch")
        with self._telling("touch", before=True):
            start = start or await self._machine()
        here = dict(zip(self.bench.axes, self.bench.to_bench(start), strict=True))
        self._check_path(here, here | {axis: float(to)})
        if "P" in self._pins():
            raise ActionFailed("Touching", f"{self._name()}: its probe touches already", "no")
        machine_axis, end = self.bench.to_machine(AXES.index(axis), float(to))
        way = end - start[machine_axis]
        line = self._touch_line(machine_axis, way, feed)
        with self._telling(f"touch on the way to {axis} {to:g} mm (`{line}`)"):
            contact = await self._probe(goal, machine_axis, way, feed)
            stands = await self._machine() if contact is None else contact
        if contact is not None:
            return self._place(contact)
        if abs(stands[machine_axis] - end) > 2 * self.tolerance:
            at = f"{axis} {self._place(stands)[axis]:g} mm instead of {to:g} mm"
            words = f"{self._name()}: its probe touched nothing, and it stands at {at}"
            raise ActionFailed("WrongPlace", words, "yes")
        words = f"{self._name()} went to {axis} {to:g} mm, and its probe touched nothing"
        raise ActionFailed("NoContact", words, "yes")

    async def _switch(self, goal: GoalContext, output: str, on: bool, power: float) -> None:
        await self._ready()
        line = self.outputs[output].line(on, power, self.full_power)
        with self._telling(f"switch {output} (`{line}`)"):
            self.on.add(output)
            try:
                await self._carry_out(line)
            except Refused:
                self.on.discard(output)
                raise
            if not on:
                self.on.discard(output)

    async def override(
        self, goal: GoalContext, *, feed: int | None = None, rapid: int | None = None
    ) -> dict[str, Any]:
        self._check_connected("override")
        with self._telling("override"):
            await self._override(feed, rapid)
        return {}

    async def go_to_zero(
        self, goal: GoalContext, *, axes: list[str] | None = None, feed: float | None = None
    ) -> dict[str, Any]:
        self.bench.check_axes(axes or (), self._name())
        await self._ready()
        self._check_homed("go to the work zero")
        offset = self._offset()
        if offset is None:
            raise ActionFailed(
                "Offline", f"{self._name()} has not reported its work zero yet", "no"
            )
        zero = dict(zip(self.bench.axes, self.bench.to_bench(offset), strict=True))
        return await self._travel(
            goal, {axis: zero[axis] for axis in axes or self.bench.axes}, feed
        )

    async def set_zero(self, goal: GoalContext, *, axes: list[str] | None = None) -> dict[str, Any]:
        self.bench.check_axes(axes or (), self._name())
        await self._ready()
        self._check_homed("set the work zero")
        named = sorted(self.bench.index[AXES.index(axis)] for axis in axes or self.bench.axes)
        with self._telling(f"set the work zero of {', '.join(LETTERS[axis] for axis in named)}"):
            self.by_hand = {"goal_id": goal.id}
            await self._set_zero(named)
            offset = self._offset()
            zero = self._place(await self._machine() if offset is None else offset)
        self.by_hand |= zero
        return zero

    async def _travel(
        self,
        goal: GoalContext,
        wanted: dict[str, float],
        feed: float | None,
        safe_z: float | None = None,
    ) -> dict[str, Any]:
        self._check_target(wanted, safe_z)
        if feed is not None:
            self._check_feed(feed)
        start = await self._ready()
        if not self.homed and self.place.config.get("home_first"):
            await self.home(goal)
            start = None
            self._check_target(wanted, safe_z)  # homing may have given the machine's range
        self._check_homed("move")
        with self._telling(f"move to {_axes_words(wanted)}", before=True):
            start = start or await self._machine()
        here = dict(zip(self.bench.axes, self.bench.to_bench(start), strict=True))
        way, at = legs(here, wanted, safe_z), here
        for leg in way:
            self._check_path(at, at | leg)
            at = at | leg
        machine = start
        for leg in way:
            end = dict(self.bench.to_machine(AXES.index(axis), v) for axis, v in leg.items())
            words = f"move to {_axes_words(leg)} (`{self._move_line(end, feed)}`)"
            with self._telling(words):
                machine = await self._drive(goal, end, feed)
                self._publish(machine)
        return self._place(machine)

    def _check_target(self, wanted: dict[str, float], safe_z: float | None) -> None:
        self.bench.check_axes(wanted, self._name())
        self.bench.check_range(wanted, self._name())
        if safe_z is not None:
            self.bench.check_range({"z": safe_z}, self._name())

    def _check_path(self, here: dict[str, float], there: dict[str, float]) -> None:
        self.bench.check_path(tuple(here.values()), tuple(there.values()), self._name())

    def _check_feed(self, feed: float) -> None:
        if not 0 < feed < math.inf:
            raise ActionFailed("SoftLimit", f"a feed of {feed:g} mm/min is not possible", "no")

    async def _outputs_off(self) -> None:
        """Switch off what is on. What a reset or an alarm has switched off already refuses it."""
        for output in sorted(self.on):
            with suppress(Refused):
                await self._carry_out(self.outputs[output].off)
            self.on.discard(output)

    def _more_status(self, machine: Point | None) -> dict[str, Any]:
        """What gantry@2 tells beyond gantry@1; nothing where the lab says gantry@1."""
        if self.place.contract is None or "pins" not in self.place.contract.status["properties"]:
            return {}
        told: dict[str, Any] = {"pins": self._pins(), "outputs": sorted(self.on)}
        named = zip(("feed_override", "rapid_override"), self._overrides(), strict=False)
        places = zip(AXES, machine or (), strict=False)
        code = re.match(r"ALARM:(\d+)", self.known.alarm)
        told["alarm_code"] = int(code[1]) if code else None
        return told | dict(named) | {f"machine_{a}": round(v, 4) + 0.0 for a, v in places}

    def _check_connected(self, asked: str) -> None:
        if self.known.lost:
            words = f"{self._name()} was asked to {asked}, but {self.known.lost}{self.when_lost}"
            if asked in ("hold", "halt"):
                words += ". Whether it still moves is unknown"
            raise ActionFailed("Offline", words, "no")

    async def _ready(self) -> Point | None:
        """Query its state; raise ActionFailed if no motion may begin. Returns what `_look` does."""
        self._check_connected("move")
        with self._telling("report its state", before=True):
            stands = await self._look()
        if self.known.alarm:
            words = f"{self._name()} was not moved: {self.known.alarm}"
            raise ActionFailed("Alarm", words, "no")
        if state := self._held_in():
            words = f"it is in state {state}; resume or halt it first"
            raise ActionFailed("Held", f"{self._name()} was not moved: {words}", "no")
        return stands

    @contextmanager
    def _under_way(self, doing: str) -> Iterator[None]:
        """Around a motion: until it ends, a stop ends it."""
        self._doing, self._stopped = doing, False
        try:
            yield
        finally:
            self._doing = None

    def _ended(self, goal: GoalContext) -> Callable[[], bool]:
        """Whether a cancel or a stop wants the motion to end."""
        return lambda: goal.cancelled.is_set() or self._stopped

    def _ending(self, goal: GoalContext, error: str, happened: Happened) -> Exception:
        """How a motion that was ended early is reported."""
        machine = self._place_known()
        where = (
            place_words(self.bench.to_bench(machine))
            if machine and self.homed
            else "an unknown position"
        )
        if goal.cancelled.is_set():
            return ActionCanceled(f"stopped at {where}")
        words = f"a stop ended the motion of {self._name()} at {where}"
        return ActionFailed(error, words, happened)

    def _check_homed(self, asked: str) -> None:
        if not self.homed:
            raise ActionFailed(
                "NotHomed",
                f"{self._name()} cannot {asked}: its position is unknown; home it first "
                f"(or write `home_first: true` in its config, and the first move will)",
                "no",
            )

    @contextmanager
    def _telling(self, asked: str, *, before: bool = False) -> Iterator[None]:
        """Turn errors within into those of the contract; `before`: nothing has been sent."""
        try:
            yield
        except MotionFault as fault:
            in_alarm = bool(self.known.alarm) or self._locked()
            error = "Offline" if before and not in_alarm else fault.error
            words = f"{self._name()} was asked to {asked}; {fault}"
            raise ActionFailed(error, words, "no" if before else fault.happened) from fault

    def _place(self, machine: Point) -> dict[str, float]:
        place = self.bench.to_bench(machine)
        return {a: round(v, 4) + 0.0 for a, v in zip(self.bench.axes, place, strict=True)}

    def _standing(self, machine: Point | None, work: Point | None) -> dict[str, float]:
        """Where it stands, for `status`; nothing while that is not known."""
        if machine is None or not self.homed:
            return {}
        return self._place(machine) | self._from_zero(work)

    def _from_zero(self, work: Point | None) -> dict[str, float]:
        """The position relative to the work zero, along the bench's axes."""
        if work is None:
            return {}
        bench = self.bench
        return {
            f"work_{a}": round(sign * work[index], 4) + 0.0
            for a, sign, index in zip(bench.axes, bench.sign, bench.index, strict=True)
        }

    def _publish(self, machine: Point) -> None:
        """Publish its position to simulated instruments that ride on a real gantry."""
        if machine != self._published:
            self._published = machine
            self.world.publish(self.place.device, self._place(machine))


def _axes_words(wanted: dict[str, float]) -> str:
    lengths = " ".join(f"{axis} {value:g}" for axis, value in wanted.items() if unit(axis) == "mm")
    turns = "".join(f" {a} {v:g} deg" for a, v in wanted.items() if unit(a) == "deg")
    return (lengths + " mm" if lengths else "") + turns
