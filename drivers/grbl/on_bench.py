"""What every gantry behind GRBL does alike, whoever carries its lines: ranges, places, words."""

import math
from abc import abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, ClassVar

from ..driver import ActionFailed, Driver, GoalContext, Place
from ..twins.world import World
from .bench import AXES, Bench, Point, read_bench, whole_limits
from .config import check_config
from .faults import GrblFault
from .settings import Settings

MODES = "G21G90G94"
"""Millimetres, absolute, per minute: said in every line, since a reset or another program unsets it."""


class OnBench(Driver):
    """Keeps the part of gantry@1 that is the same over a serial port and over OpenBuilds CONTROL."""

    contract: ClassVar[str] = "gantry@1"
    options: ClassVar[tuple[str, ...]] = ()

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        check_config(place.device, place.config, self.options)
        self.limits = whole_limits(place)
        self.bench: Bench = read_bench(place.config, self.limits, Settings())
        self.world = World(place.world)
        self._published: Point | None = None
        self._by_hand: dict[str, Any] = {"goal_id": None}

    @property
    @abstractmethod
    def homed(self) -> bool:
        """Whether the position is trusted."""

    @abstractmethod
    async def home(self, goal: GoalContext) -> dict[str, Any]:
        """Find the machine's zero."""

    @abstractmethod
    def _name(self) -> str:
        """The device as a message calls it."""

    @abstractmethod
    async def _ready(self) -> None:
        """Ask how it is; raise ActionFailed where no motion may begin."""

    @abstractmethod
    async def _machine(self) -> Point:
        """Where it stands, asked now; raises GrblFault."""

    @abstractmethod
    def _offset(self) -> Point | None:
        """The work zero in machine coordinates; None as long as it is not known."""

    @abstractmethod
    async def _drive(self, goal: GoalContext, line: str, end: dict[int, float]) -> Point:
        """Do a move, prove that it ended, and verify it: `end` by machine axis, in mm."""

    @abstractmethod
    async def _set_zero(self, line: str) -> None:
        """Do a `G10 L20`, and learn the new offset."""

    async def move_to(
        self,
        goal: GoalContext,
        *,
        x: float | None = None,
        y: float | None = None,
        z: float | None = None,
        feed: float | None = None,
    ) -> dict[str, Any]:
        given = zip(AXES, (x, y, z), strict=True)
        wanted = {axis: float(value) for axis, value in given if value is not None}
        return await self._go(goal, wanted, feed)

    async def go_to_zero(
        self, goal: GoalContext, *, axes: list[str] | None = None, feed: float | None = None
    ) -> dict[str, Any]:
        await self._ready()
        self._check_homed("go to the work zero")
        offset = self._offset()
        if offset is None:
            raise ActionFailed("Offline", f"{self._name()} has not told its work zero yet", "no")
        zero = dict(zip(AXES, self.bench.to_bench(offset), strict=True))
        return await self._go(goal, {axis: zero[axis] for axis in axes or AXES}, feed)

    async def set_zero(self, goal: GoalContext, *, axes: list[str] | None = None) -> dict[str, Any]:
        await self._ready()
        self._check_homed("set the work zero")
        letters = ("XYZ"[self.bench.index[AXES.index(axis)]] for axis in axes or AXES)
        line = "G10L20P0" + "".join(f"{letter}0" for letter in sorted(letters))
        with self._telling(line):
            self._by_hand = {"goal_id": goal.id}
            await self._set_zero(line)
            offset = self._offset()
            zero = self._place(await self._machine() if offset is None else offset)
        self._by_hand |= zero
        return zero

    async def last_by_hand(self, goal: GoalContext) -> dict[str, Any]:
        return self._by_hand

    async def _go(
        self, goal: GoalContext, wanted: dict[str, float], feed: float | None
    ) -> dict[str, Any]:
        self.bench.check_range(wanted, self._name())
        if feed is not None and not 0 < feed < math.inf:
            raise ActionFailed("SoftLimit", f"a feed of {feed:g} mm/min is none", "no")
        await self._ready()
        if not self.homed and self.place.config.get("home_first"):
            await self.home(goal)
            self.bench.check_range(wanted, self._name())  # homing may have told the machine's reach
        self._check_homed("move")
        with self._telling(f"move to {_axes_words(wanted)}", before=True):
            start = await self._machine()
        here = dict(zip(AXES, self.bench.to_bench(start), strict=True))
        there = here | wanted
        self.bench.check_path(
            self.bench.to_bench(start), (there["x"], there["y"], there["z"]), self._name()
        )
        end = dict(self.bench.to_machine(AXES.index(axis), v) for axis, v in wanted.items())
        line = _line(end, feed)
        with self._telling(f"move to {_axes_words(wanted)} (`{line}`)"):
            return self._place(await self._drive(goal, line, end))

    def _check_homed(self, asked: str) -> None:
        if not self.homed:
            raise ActionFailed(
                "NotHomed",
                f"{self._name()} was asked to {asked}, but does not know where it is; home it "
                f"first (or write `home_first: true` in its config, and the first move will)",
                "no",
            )

    @contextmanager
    def _telling(self, asked: str, *, before: bool = False) -> Iterator[None]:
        """What goes wrong within, told as the contract wants; `before`: nothing has been sent."""
        try:
            yield
        except GrblFault as fault:
            error = "Offline" if before and not self._in_alarm() else fault.error
            words = f"{self._name()} was asked to {asked}; {fault}"
            raise ActionFailed(error, words, "no" if before else fault.happened) from fault

    @abstractmethod
    def _in_alarm(self) -> bool:
        """Whether an alarm keeps it from moving."""

    def _place(self, machine: Point) -> dict[str, float]:
        x, y, z = (round(value, 4) + 0.0 for value in self.bench.to_bench(machine))
        return {"x": x, "y": y, "z": z}

    def _from_zero(self, work: Point | None) -> dict[str, float]:
        """The place from the work zero, along the bench's axes."""
        if work is None:
            return {}
        signed = (self.bench.sign[i] * work[self.bench.index[i]] for i in range(len(AXES)))
        return {f"work_{a}": round(v, 4) + 0.0 for a, v in zip(AXES, signed, strict=True)}

    def _publish(self, machine: Point) -> None:
        """Show simulated instruments that ride on a real gantry where it is."""
        if machine != self._published:
            self._published = machine
            self.world.publish(self.place.device, self._place(machine))


def _line(end: dict[int, float], feed: float | None) -> str:
    """One straight move in machine coordinates, whatever work zero is set."""
    words = "".join(f"{'XYZ'[axis]}{value:.4f}" for axis, value in sorted(end.items()))
    return f"{MODES}G53G0{words}" if feed is None else f"{MODES}G53G1{words}F{feed:.3f}"


def _axes_words(wanted: dict[str, float]) -> str:
    return " ".join(f"{axis} {value:g}" for axis, value in wanted.items()) + " mm"
