"""Zaber stages, as a driver.

Configuration: `port`, `stages`, `home_order` ([z, x, y]), `device_db` (the maker's database, a file),
`silence_s` (how long an answer may take), `origin`, `axes`, `keep_out`, `home_first`, `homing_timeout`
(s), `safe_z`, `outputs`. `docs/how-to/gantry.md` explains each.
"""

import asyncio
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

from ..driver import GoalContext, Place
from ..motion.bench import Point, read_bench
from ..motion.config import PLACING
from ..motion.faults import Ended, HomingFailed, MotionFault, NotStopped, NotThere
from ..motion.fed_gantry import FedGantry, fastest
from ..motion.gantry import AXES
from .config import read_stages

LOOK_S = 0.02
STANDS_S = 30.0
"""How long it may take until all stages stand; they are given a quarter of a second of their way at most."""
LINE = re.compile(r"(\d+)(?: (\d+))? ([a-z].*)")
"""An output's line: device, axis if it has one, command."""


class Zaber(FedGantry):
    """Implements gantry@2 with the stages that the lab names; reconnects when they are back."""

    options: ClassVar[tuple[str, ...]] = (
        "port", "stages", "home_order", "device_db", "silence_s", *PLACING
    )  # fmt: skip
    extra: ClassVar[str | None] = "zaber"
    piece_s: ClassVar[float] = 0.1

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        if not place.config.get("port"):
            raise ValueError(
                "config needs `port`, such as /dev/serial/by-id/usb-..., COM5 or tcp://10.0.0.9"
            )
        self._wanted = read_stages(place.config.get("stages"))
        self._order = self._homing_order()
        for name, output in self.outputs.items():
            if not (LINE.fullmatch(output.on) and LINE.fullmatch(output.off)):
                raise ValueError(
                    f"output {name}: write its lines with the device's number before them: "
                    f"{{on: 1 io set do 1 1, off: 1 io set do 1 0}}"
                )
        database = place.config.get("device_db")
        self._database = None if database is None else Path(database).expanduser()
        from .chain import Chain  # the maker's library is loaded here

        self.known = self.chain = Chain(
            str(place.config["port"]), float(place.config.get("silence_s", 1.0))
        )
        self.alone = f"Zaber on {self.chain.port}"
        self._way: dict[int, float] = {}

    def _homing_order(self) -> list[int]:
        names = [AXES[number] for number in self._wanted]
        usual = sorted(names, key=lambda name: name != "z")
        order = self.place.config.get("home_order", usual)
        if not isinstance(order, list) or sorted(order) != sorted(names):
            raise ValueError(f"home_order is {order!r}; it names each of {', '.join(usual)} once")
        return [AXES.index(name) for name in order]

    async def _let_go(self) -> None:
        await self.chain.close("it was closed")

    async def _reach(self) -> None:
        chain = self.chain
        await chain.open(self._wanted, self._database)
        ranges = [(0.0, 0.0)] * max(3, max(self._wanted) + 1)
        for axis, stage in chain.stages.items():
            ranges[axis] = stage.low, stage.high
        self.bench = read_bench(self.place.config, self.limits, ranges)
        self.tolerance = max(0.001, *(2 * stage.scale for stage in chain.stages.values()))
        try:
            await self._machine()
        except MotionFault as fault:
            raise OSError(f"{chain.port}: {fault}") from fault

    async def _home(self, goal: GoalContext) -> None:
        """One stage after the other: z, where there is one, is out of the way first."""
        chain = self.chain
        with self._moving(goal, "home"):
            chain.homed = False
            for axis in self._order:
                await chain.ask(axis, "home")
                seconds = float(self.place.config.get("homing_timeout", 120))
                if not await self._stands(seconds, self._ended(goal)):
                    await self._break_off()
                    if self._ended(goal)():
                        raise Ended
                    raise HomingFailed(
                        f"axis {AXES[axis]} did not end within `homing_timeout`, and was stopped"
                    )
            await chain.forget_faults()
            chain.homed = True
            await chain.look()
            await self._machine()
            if not chain.homed:
                raise HomingFailed(
                    chain.alarm or "it ended, but not all stages know where they are"
                )

    async def _stands(self, seconds: float, ended: Callable[[], bool] = lambda: False) -> bool:
        """Whether all stages stand within this time; False at once where it is to end."""
        clock = asyncio.get_running_loop().time
        until = clock() + seconds
        while await self.chain.busy():
            if ended() or clock() > until:
                return False
            await asyncio.sleep(LOOK_S)
        return True

    async def _break_off(self) -> None:
        await self.chain.stop()
        if not await self._stands(self.stop_s):
            raise NotStopped(
                "it was told to stop and still moves: switch its power off if it must stand now"
            )

    async def _stop(self) -> None:
        """What is fed ends by itself, after a quarter of a second; a stop does not wait for that."""
        if self._doing != "home" and not self.chain.lost:
            await self._break_off()
        await super()._stop()

    async def unlock(self, goal: GoalContext) -> dict[str, Any]:
        """Switch drivers on again that a fault has switched off, and unpark what is parked."""
        self._check_connected("unlock")
        with self._telling("unlock"):
            await self.chain.release()
        return {}

    async def _look(self) -> None:
        await self.chain.look()

    async def _finish(self) -> None:
        if not await self._stands(STANDS_S):
            raise MotionFault(f"it still moves, {STANDS_S:g} s after the last way it was given")
        await self.chain.look()

    async def _machine(self) -> Point:
        at = [0.0] * len(self.bench.axes)
        for axis in self.chain.stages:
            at[axis] = await self.chain.place(axis)
        self._at = tuple(at)
        return self._at

    async def _feed(
        self, goal: GoalContext, start: Point, way: dict[int, float], feed: float | None,
        wanted: Callable[[], bool],
    ) -> None:  # fmt: skip
        self._way = way
        await super()._feed(goal, start, way, feed, wanted)

    async def _piece(self, place: dict[int, float], speed: float) -> None:
        """Each stage has its share of speed and acceleration: they go straight, and end together."""
        length = sum(by**2 for by in self._way.values()) ** 0.5
        _, acceleration = self._fastest(self._way)
        for axis, value in place.items():
            part = abs(self._way[axis]) / length
            stage = self.chain.stages.get(axis)
            if part and stage is not None:
                command = stage.command(value, part * speed, part * acceleration)
                await self.chain.ask(axis, command)
        if self.chain.alarm:
            raise MotionFault(self.chain.alarm)
        await self._machine()

    def _fastest(self, way: dict[int, float]) -> tuple[float, float]:
        stages = self.chain.stages.items()
        axes = {axis: (stage.speed, stage.acceleration) for axis, stage in stages}
        return fastest(way, axes) or (1.0, float("inf"))

    def _move_line(self, end: dict[int, float], feed: float | None) -> str:
        words = " ".join(f"{AXES[axis]} {value:.4f}" for axis, value in sorted(end.items()))
        return f"move abs {words}"

    def _touch_line(self, axis: int, way: float, feed: float) -> str:
        return "touch"

    async def _probe(self, goal: GoalContext, axis: int, way: float, feed: float) -> Point | None:
        raise NotThere("a Zaber stage has no input for a probe")

    async def _carry_out(self, line: str) -> None:
        found = LINE.fullmatch(line)
        assert found is not None, "outputs are checked at the start"
        await self.chain.ask_device(int(found[1]), int(found[2] or 0), found[3])

    async def _override(self, feed: int | None, rapid: int | None) -> None:
        if {feed, rapid} - {None, 100}:
            raise NotThere("Zaber stages have no override; give a move its `feed`")

    def _overrides(self) -> tuple[int, ...]:
        return (100, 100)

    def _name(self) -> str:
        return f"{self.place.device} (Zaber on {self.chain.port})"
