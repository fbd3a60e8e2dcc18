"""The gantry behind Marlin, as a driver.

Configuration: `port`, `baud` (115200), `boot_s` (how long its start may take), `origin`, `axes`,
`keep_out`, `home_first`, `homing_timeout` (s), `safe_z`, `outputs`. `docs/how-to/gantry.md` explains each.
"""

import asyncio
import contextlib
from typing import Any, ClassVar

from ...system.tasks import end, spawn
from ..driver import GoalContext, Place
from ..motion.bench import LETTERS, Point, read_bench
from ..motion.config import PLACING
from ..motion.faults import Ended, HomingFailed, MotionFault, NotStopped, NotThere
from ..motion.fed_gantry import FedGantry, fastest
from .link import Link
from .machine import Machine, read_machine, read_pins, read_place, read_shift

CLOSED_S = 0.3
"""How long the port stays closed, so that the board notices."""
LOOK_S = 0.05
BROKEN_OFF_S = 3.0
UNHELD = (
    "another program has sent it elsewhere, and it does not tell whether it is there: if it still moves, "
    "it was not held, which Marlin cannot do; `halt` ends it without braking"
)
STOPPED = "it was stopped without braking in a move of another program (`M410`); home it"
ABSOLUTE = "G90"
SHIFTED_MM = 0.05
"""More than the rounding of M114 and of a step."""
STAYS_ON = "M84 S0"
"""It lets go of its motors after two minutes otherwise, and goes on trusting its position."""


class Marlin(FedGantry):
    """Implements gantry@2 with three axes; the port is reopened by itself after it was unplugged."""

    options: ClassVar[tuple[str, ...]] = ("port", "baud", "boot_s", *PLACING)

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        if not place.config.get("port"):
            raise ValueError("config needs `port`, such as /dev/serial/by-id/usb-... or COM5")
        baud = int(place.config.get("baud", 115200))
        self.known = self.link = Link(str(place.config["port"]), baud)
        self.alone = f"Marlin on {self.link.port.name}"
        self.machine = Machine()
        self._capabilities: list[str] = []
        self.full_power = 255.0
        self.percent: tuple[int, ...] = (100, 100)
        self._engaged = ""
        self._shift: Point | None = None
        self._shift_at_rest: Point | None = None
        self._rest: Point | None = None
        """Where it was when it last stood, for certain."""

    async def _let_go(self) -> None:
        await self.link.close("it was closed")

    async def _reach(self) -> None:
        link = self.link
        await link.open(float(self.place.config.get("boot_s", 5)))
        try:
            self._capabilities = await link.ask("M115")
            await self._learn()
            for line in ("G21", ABSOLUTE, STAYS_ON, "M220 S100"):
                with contextlib.suppress(NotThere):  # a build without inches has no G21
                    await link.ask(line)
            await self._still()
        except MotionFault as fault:
            raise OSError(f"{link.port.name}: Marlin was reached, but {fault}") from fault

    async def _learn(self) -> None:
        told = [*await self.link.ask("M503"), *await self.link.ask("M211")]
        try:
            self.machine = read_machine(told, self._capabilities)
        except ValueError as fault:
            raise MotionFault(str(fault)) from fault
        self.bench = read_bench(self.place.config, self.limits, self.machine.ranges)
        self.tolerance = self.machine.tolerance

    async def _reach_again(self) -> None:
        """Reopen the port; the gantry's position is then unknown."""
        why = self.link.lost
        await self.link.port.close()
        await asyncio.sleep(CLOSED_S)
        self.link.alarm = f"the connection was lost ({why}) and is back. Home it"
        await self._reach()

    async def _home(self, goal: GoalContext) -> None:
        """Run `G28` to its end; only a build with an emergency parser can be stopped in it."""
        link = self.link
        link.homed = False
        with self._moving(goal, "home"):
            if link.halted:
                await self._restart()
            asked = spawn(f"homing {link.port.name}", link.ask("G28"), expected=(MotionFault,))
            clock = asyncio.get_running_loop().time
            until = clock() + float(self.place.config.get("homing_timeout", 120))
            while not asked.done():
                await asyncio.wait({asked}, timeout=LOOK_S)
                if not asked.done() and (self._ended(goal)() or clock() > until):
                    await self._break_off()
                    await asyncio.wait({asked}, timeout=BROKEN_OFF_S)
                    await end(asked)
                    if self._ended(goal)():
                        raise Ended
                    raise HomingFailed("it did not end within `homing_timeout`, and was stopped")
            try:
                told = asked.result()
            except NotThere as fault:
                raise HomingFailed(str(fault)) from fault
            if faults := [line for line in told if "fail" in line.lower()]:
                raise HomingFailed(f"it said `{faults[0]}`")
            # Another program may have set it, and a `G92` has shifted its ranges.
            await self._learn()
            await self._still()
            await link.ask(STAYS_ON)
            link.homed, link.alarm = True, ""

    async def status(self) -> dict[str, Any]:
        """Where another program has sent it shows in what it has planned, and not whether it is there."""
        if self._doing is None and self.homed and not self.link.busy:
            with contextlib.suppress(MotionFault):
                await self._machine()
        return await super().status()

    def _place_known(self) -> Point | None:
        return None if self._sent_elsewhere else self._at

    @property
    def _sent_elsewhere(self) -> bool:
        return self._doing is None and self._at != self._rest

    async def _runs(self) -> bool:
        if self.link.halted:
            return False
        await self._machine()
        return self._sent_elsewhere

    async def _hold(self) -> None:
        if self._doing is None:
            raise NotStopped(UNHELD)
        await super()._hold()

    async def _stop(self) -> None:
        """It tells where a move will end, and not that it moves: so another program's is ended unseen."""
        link = self.link
        if self._doing is None and not (link.halted or link.lost):
            planned = await self._machine()
            await link.ask("M410")
            stands = await self._still()
            if any(abs(a - b) > self.tolerance for a, b in zip(planned, stands, strict=True)):
                link.homed, link.alarm = False, STOPPED
        await super()._stop()

    async def _break_off(self) -> None:
        """Halt the firmware itself: it has nothing milder that works while it homes or touches."""
        link = self.link
        link.homed = False
        if not self.machine.quick_stop:
            raise NotStopped(
                "this Marlin was built without EMERGENCY_PARSER: it takes no stop before it has "
                "homed or touched; press its emergency stop if it must stand now"
            )
        link.at_once("M112")
        if not await link.until(lambda: bool(link.alarm or link.lost), BROKEN_OFF_S):
            raise NotStopped(
                "it did not confirm its halt and may still move: press its emergency stop"
            )

    async def unlock(self, goal: GoalContext) -> dict[str, Any]:
        """A halted Marlin is restarted by opening its port again, which resets most boards."""
        self._check_connected("unlock")
        link = self.link
        with self._telling("unlock"):
            if link.halted:
                await self._restart()
            if link.alarm:
                await self._still()
                link.alarm, link.homed = "", False
        return {}

    async def _restart(self) -> None:
        await end(self._keeper)
        await self.link.port.close()
        await asyncio.sleep(CLOSED_S)
        try:
            await self._reach()
        except OSError as fault:
            raise MotionFault(f"it did not come back ({fault}); switch it off and on") from fault
        finally:
            self._keep()

    async def _look(self) -> Point | None:
        if self.link.halted:
            return None
        await self.link.ask(ABSOLUTE)  # a file on its card, or its screen, may have changed that
        machine = await self._machine()
        if self.link.homed and (self._shifted() or self._sent_elsewhere):
            before = self._shift_at_rest
            machine = await self._still()  # its steps lag behind a move of another program
            self._shift_at_rest = before
            if by := self._shifted():
                self.link.homed = False
                self.link.alarm = (
                    f"another program has shifted its zero by {by} (`G92`, `M206`, `M92`); home it"
                )
        return machine

    def _shifted(self) -> str:
        """By what its position and its steps differ more than when it came to rest; empty if they do not."""
        now, then = self._shift, self._shift_at_rest
        by = [] if now is None or then is None else [a - b for a, b in zip(now, then, strict=True)]
        named = zip(LETTERS, by, strict=False)
        return ", ".join(f"{axis} {mm:.2f} mm" for axis, mm in named if abs(mm) > SHIFTED_MM)

    async def _still(self) -> Point:
        machine = self._rest = await super()._still()
        self._shift_at_rest = self._shift
        return machine

    async def _finish(self) -> None:
        await self.link.ask("M400")
        self._engaged = read_pins(await self.link.ask("M119"))

    async def _machine(self) -> Point:
        told = await self.link.ask("M114")
        if read_place(told) is None:  # noise in it, or it answered another line
            await self.link.in_step()
            told = await self.link.ask("M114")
        place, self._shift = read_place(told), read_shift(told, self.machine)
        if place is None:
            raise MotionFault(f"it does not report where it is; {self.link.last_words}")
        self._at = place
        return place

    async def _piece(self, place: dict[int, float], speed: float) -> None:
        await self.link.ask(self._move_line(place, speed * 60))

    def _fastest(self, way: dict[int, float]) -> tuple[float, float]:
        machine = self.machine
        axes = dict(enumerate(zip(machine.speed, machine.acceleration, strict=True)))
        return fastest(way, axes) or (min(machine.speed), min(machine.acceleration))

    def _move_line(self, end: dict[int, float], feed: float | None) -> str:
        words = "".join(f" {LETTERS[axis]}{value:.4f}" for axis, value in sorted(end.items()))
        return f"G0{words}" if feed is None else f"G1{words} F{feed:.1f}"

    def _touch_line(self, axis: int, way: float, feed: float) -> str:
        return f"G38.3 {LETTERS[axis]}{way:.4f} F{feed:.1f}"

    async def _probe(self, goal: GoalContext, axis: int, way: float, feed: float) -> Point | None:
        with self._moving(goal, "touch"):
            start = await self._machine()
            line = self._touch_line(axis, start[axis] + way, feed)
            await self.link.ask(line)
            place = await self._still()
            if self._ended(goal)():
                raise Ended
            # It says nothing of the contact, but stands where it was.
            return None if abs(place[axis] - start[axis] - way) <= self.tolerance else place

    async def _carry_out(self, line: str) -> None:
        await self.link.ask(line)
        await self.link.ask("M400")

    async def _override(self, feed: int | None, rapid: int | None) -> None:
        """Marlin has one override for both, which begins with the next piece."""
        wanted = feed if feed is not None else rapid
        if feed is not None and rapid not in (None, 100):
            raise NotThere("Marlin has one override for feed and rapid moves; give `feed` alone")
        told = await self.link.ask(f"M220 S{wanted}") + await self.link.ask("M220")
        if not any(f"FR:{wanted}%" in line.replace(" ", "") for line in told):
            raise MotionFault(f"it reports {self.link.last_words}")
        self.percent = (int(wanted or 100),) * 2

    def _pins(self) -> str:
        return self._engaged

    def _overrides(self) -> tuple[int, ...]:
        return self.percent

    def _name(self) -> str:
        return f"{self.place.device} (Marlin on {self.link.port.name})"
