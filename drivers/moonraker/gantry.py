"""The gantry behind Klipper and Moonraker, as a driver.

Configuration: `url` (http://localhost:7125), `api_key`, `origin`, `axes`, `keep_out`, `home_first`,
`homing_timeout` (s), `safe_z`, `outputs`. `docs/how-to/gantry.md` explains each.
"""

import asyncio
import contextlib
import re
from collections.abc import Iterator
from typing import Any, ClassVar

from ...system.tasks import end, spawn
from ..driver import GoalContext, Place
from ..motion.bench import LETTERS, Point, read_bench
from ..motion.config import PLACING
from ..motion.faults import Ended, HomingFailed, MotionFault, NotStopped, NotThere, Refused, Silent
from ..motion.fed_gantry import FedGantry, fastest
from .link import Link

PLACE = re.compile(r"X:(-?[\d.]+) Y:(-?[\d.]+) Z:(-?[\d.]+)")
AGAIN_S = 1.0
LOOK_S = 0.05
READY_S = 30.0
RESTART_S = 5.0
"""How long a restart may take until it is asked for again."""
HALTED_S = 3.0
MOTION_S = 60.0
"""How long the last piece of a move may take."""


class Moonraker(FedGantry):
    """Implements gantry@2 with three axes; reconnects when Moonraker and Klipper are back."""

    options: ClassVar[tuple[str, ...]] = ("url", "api_key", *PLACING)
    piece_s: ClassVar[float] = 0.1
    ahead_s: ClassVar[float] = 0.6
    """Klipper itself plans a quarter of a second ahead, and makes a stop at every way that ends before."""

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        url = str(place.config.get("url", "http://localhost:7125"))
        if not url.startswith(("http://", "https://")):
            raise ValueError(f"url is {url!r}; write it as http://localhost:7125")
        key = place.config.get("api_key")
        self.known = self.link = Link(url, None if key is None else str(key))
        self.alone = f"Klipper by {url}"
        self.full_power = 255.0
        self._slow_z: tuple[float, float] | None = None

    async def _let_go(self) -> None:
        await self.link.close("it was closed")

    async def _reach(self) -> None:
        await self.link.open()
        await self._learn()

    async def _learn(self) -> None:
        """Read speeds and ranges, if Klipper is ready; raises OSError."""
        link = self.link
        if link.lost:
            raise OSError(f"{self._name()}: {link.lost}")
        if link.halted:
            return  # `unlock` restarts it
        try:
            told = await link.ask("printer.objects.query", objects={"configfile": ["settings"]})
            await link.run("G90")
            await self._still()
        except MotionFault as fault:
            raise OSError(f"{self._name()} was reached, but {fault}") from fault
        printer = told["status"]["configfile"]["settings"].get("printer", {})
        z = printer.get("max_z_velocity"), printer.get("max_z_accel")
        self._slow_z = (float(z[0]), float(z[1])) if None not in z else None
        toolhead = link.status["toolhead"]
        ranges = zip(toolhead["axis_minimum"][:3], toolhead["axis_maximum"][:3], strict=True)
        self.bench = read_bench(self.place.config, self.limits, list(ranges))

    async def _home(self, goal: GoalContext) -> None:
        link = self.link
        if link.prints:
            raise Refused(link.alarm)
        link.homed = False
        with self._moving(goal, "home"), _may_have_moved():
            await link.learn()  # Klipper's answer to another program may be ahead of its own news
            if link.halted:
                await self._restart()
            seconds = float(self.place.config.get("homing_timeout", 120))
            asked = spawn(
                f"homing by {link.url}", link.run("G28", seconds), expected=(MotionFault,)
            )
            while not asked.done():
                await asyncio.wait({asked}, timeout=LOOK_S)
                if not asked.done() and self._ended(goal)():
                    await self._break_off()
                    await asyncio.wait({asked}, timeout=HALTED_S)
                    await end(asked)
                    raise Ended
            try:
                asked.result()
            except Silent:
                await self._break_off()
                raise HomingFailed(
                    "it did not end within `homing_timeout`, and was halted"
                ) from None
            await link.run("G90")
            link.homed = True
            await self._query()
            await self._still()
            if not link.homed:
                raise HomingFailed(
                    "it ended, but Klipper does not know where all of x, y and z are"
                )

    async def _stop(self) -> None:
        """A print, which another program has begun, goes on by itself: it is paused."""
        link = self.link
        if link.prints:
            try:
                await link.run("M25", HALTED_S)
            except MotionFault:
                await self._break_off()
            else:
                if not await link.until(lambda: not link.prints, HALTED_S):
                    await self._break_off()
                elif not link.alarm:
                    await self._finish()
        await super()._stop()

    async def _break_off(self) -> None:
        """Halt Klipper: it has nothing milder that works while it homes."""
        link = self.link
        link.homed = False
        with contextlib.suppress(MotionFault):  # it halts before it answers
            await link.ask("printer.emergency_stop", HALTED_S)
        if not await link.until(lambda: link.halted or bool(link.lost), HALTED_S):
            raise NotStopped(
                "it did not confirm its halt and may still move: press its emergency stop"
            )
        with contextlib.suppress(MotionFault):
            await link.learn()  # why, in Klipper's words

    async def unlock(self, goal: GoalContext) -> dict[str, Any]:
        """Restart a Klipper that has halted; it has to be homed then."""
        self._check_connected("unlock")
        link = self.link
        with self._telling("unlock"):
            await link.learn()
            if link.halted:
                await self._restart()
        return {}

    async def _restart(self) -> None:
        """Restart Klipper until it is ready: one whose board was not ready yet comes up in state error."""
        link, clock = self.link, asyncio.get_running_loop().time
        await end(self._keeper)  # it would connect again meanwhile
        try:
            until, next_at = clock() + READY_S, 0.0
            while clock() < until and (link.lost or link.halted):
                if link.halted and clock() >= next_at:
                    next_at = clock() + RESTART_S
                    with contextlib.suppress(MotionFault):  # it is gone before it has answered
                        await link.ask("printer.firmware_restart")
                await asyncio.sleep(AGAIN_S)
                with contextlib.suppress(MotionFault, OSError):
                    await (link.open() if link.disconnected else link.learn())
            await self._learn()
        except OSError as fault:
            raise MotionFault(f"it was restarted; {fault}") from fault
        finally:
            self._keep()
        if link.halted:
            raise MotionFault(
                f"it was restarted, and is not ready after {READY_S:g} s: {link.trouble}. See to its "
                "board's power and cable, then restart Klipper itself"
            )

    async def _look(self) -> None:
        """Klipper tells of a change by itself."""

    async def _query(self) -> None:
        told = await self.link.ask(
            "printer.objects.query", objects=dict.fromkeys(("toolhead", "gcode_move"))
        )
        self.link._update(told.get("status"))

    def _locked(self) -> bool:
        return self.link.halted

    def _place_known(self) -> Point | None:
        live = self.link.status.get("motion_report", {}).get("live_position")
        return tuple(map(float, live[:3])) if self._doing and live else self._at

    async def _finish(self) -> None:
        """By a question to its boards, which is sent when the last move has ended.

        M400 asks Klipper's own clock: it was answered, and the next moves were, while a board was gone.
        """
        await self.link.run("QUERY_ENDSTOPS", MOTION_S)

    async def _machine(self) -> Point:
        """By M114: a query is answered four times a second only."""
        told = self.link.status.get("gcode_move", {})
        at, shown = told.get("position"), told.get("gcode_position")
        said = [found for line in await self.link.run("M114") if (found := PLACE.match(line))]
        if said and at and shown:
            x, y, z = (float(said[-1][i + 1]) + at[i] - shown[i] for i in range(3))
            self._at = (x, y, z)
            self.link.status.get("motion_report", {}).pop("live_position", None)  # older than this
            return self._at
        await self._query()
        x, y, z, *_ = self.link.status["toolhead"]["position"]
        self._at = (x, y, z)
        return self._at

    async def _piece(self, place: dict[int, float], speed: float) -> None:
        # Another program may have set relative moves at any time.
        await self.link.run(f"G90\n{self._move_line(place, speed * 60)}", MOTION_S)

    def _fastest(self, way: dict[int, float]) -> tuple[float, float]:
        toolhead = self.link.status["toolhead"]
        speed, acceleration = float(toolhead["max_velocity"]), float(toolhead["max_accel"])
        z = None if self._slow_z is None else fastest(way, {2: self._slow_z})
        return (speed, acceleration) if z is None else (min(speed, z[0]), min(acceleration, z[1]))

    def _move_line(self, end: dict[int, float], feed: float | None) -> str:
        """In Klipper's G-code coordinates, which another program may have shifted (G92, an offset)."""
        told = self.link.status.get("gcode_move", {})
        at, shown = told.get("position", (0.0,) * 4), told.get("gcode_position", (0.0,) * 4)
        words = "".join(
            f" {LETTERS[axis]}{value - at[axis] + shown[axis]:.4f}"
            for axis, value in sorted(end.items())
        )
        return f"G1{words}" if feed is None else f"G1{words} F{feed:.1f}"

    def _touch_line(self, axis: int, way: float, feed: float) -> str:
        return "PROBE"

    async def _probe(self, goal: GoalContext, axis: int, way: float, feed: float) -> Point | None:
        raise NotThere(
            "Klipper probes downwards only, to where its configuration says; use its own PROBE"
        )

    async def _carry_out(self, line: str) -> None:
        if self.link.halted:  # it has switched its pins to where its configuration wants them then
            raise Refused(self.link.alarm)
        await self.link.run(line)
        await self._finish()

    async def _override(self, feed: int | None, rapid: int | None) -> None:
        wanted = feed if feed is not None else rapid
        if feed is not None and rapid not in (None, 100):
            raise NotThere("Klipper has one override for feed and rapid moves; give `feed` alone")
        await self.link.run(f"M220 S{wanted}", MOTION_S)
        await self._query()
        if self._overrides()[0] != wanted:
            raise MotionFault(f"it reports {self._overrides()[0]} %")

    def _overrides(self) -> tuple[int, ...]:
        factor = self.link.status.get("gcode_move", {}).get("speed_factor", 1.0)
        return (round(100 * factor),) * 2

    def _name(self) -> str:
        return f"{self.place.device} (Klipper by {self.link.url})"


@contextlib.contextmanager
def _may_have_moved() -> Iterator[None]:
    """Klipper refuses a homing half way, too."""
    try:
        yield
    except Refused as fault:
        raise HomingFailed(str(fault)) from fault
