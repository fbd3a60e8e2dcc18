"""The gantry behind a GRBL or grblHAL controller, as a driver.

Configuration: `port` (`/dev/serial/by-id/...`, `COM5`, `socket://host:port`,
`ws://host/`), `baud` (115200),
`origin`, `axes`, `keep_out`, `home_first`, `homing_timeout` (s), `home_here` (a machine without
switches), `boot_s` (how long the banner may take). `docs/how-to/gantry.md` explains each.
"""

import asyncio
import contextlib
from collections.abc import Callable
from dataclasses import replace
from typing import Any, ClassVar

from ...system.tasks import end, keep, spawn
from ..driver import GoalContext, Place
from ..motion.bench import Point, bench_from_here, place_words, read_bench
from ..motion.config import PLACING
from ..motion.faults import Ended, Lost, MotionFault, Refused, Restarted, Silent, WrongPlace
from .alarm import TRIES, recover
from .boot import homes_at, learn_offset, reach
from .controller import HOLD, RESUME, Contact, Controller
from .dialect import GrblDialect, changed_words, out_of_travel_words, zero_line
from .faults import SOFT_LIMIT, Alarmed, StillLocked
from .homing import home
from .jog import jog_by, jog_while
from .motion import Move
from .report import Report
from .settings import SCALE, TRAVEL, Settings
from .status_words import state_of, trouble_of
from .stopping import finished, stop, wake

AGAIN_S = 1.0
STATUS_S = 0.8
HELD_S = 3.0
READINGS = 4
NEAR_MM = 1.0
SETTINGS_S = 30.0  # behind a dwell of another program


class Grbl(GrblDialect):
    """Implements gantry@2 through pyserial; the port is reopened by itself after it was unplugged."""

    options: ClassVar[tuple[str, ...]] = ("port", "baud", "boot_s", "home_here", *PLACING)
    when_lost: ClassVar[str] = "; it reconnects when it is back"

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        if not place.config.get("port"):
            raise ValueError("config needs `port`, such as /dev/serial/by-id/usb-... or COM5")
        self.known = self.controller = Controller(
            str(place.config["port"]), int(place.config.get("baud", 115200))
        )
        self.controller.on_alarm = self._recover
        self.alone = f"GRBL on {self.controller.port.name}"
        self.controller.on_report = self._reported
        self._tasks: set[asyncio.Task[None]] = set()
        self._recovery: asyncio.Task[None] | None = None
        self._sure: asyncio.Task[None] | None = None
        self._left: Point | None = None
        """Where it stood when its settings were last known to hold."""

    async def open(self) -> None:
        await self._reach()
        self._tasks.add(keep(f"reopening {self.controller.port.name}", self._keep))

    async def close(self) -> None:
        await end(*self._tasks)
        await finished(self.controller)
        self.controller.disconnected("it was closed")
        await self.controller.port.close()

    async def status(self) -> dict[str, Any]:
        c = self.controller
        if c.contact in (Contact.READY, Contact.SILENT) and self._doing != "home":
            with contextlib.suppress(MotionFault):
                await c.look(STATUS_S)
                if self._in_doubt:
                    await asyncio.wait({self._make_sure()}, timeout=STATUS_S)
        told: dict[str, Any] = {
            "state": "offline" if self._reattaching else state_of(c, self._doing),
            "homed": c.homed,
            "alarm": trouble_of(c),
        }
        if c.report is not None:
            if c.contact in (Contact.READY, Contact.HOMING):  # else it is that of an older report
                told["feed"] = round(c.report.feed_mm_per_min, 3)
            machine = None if self._in_doubt else c.report.machine
            told |= self._standing(machine, c.report.work) | self._more_status(machine)
        return told

    async def _home(self, goal: GoalContext) -> None:
        try:
            with self._under_way("home"):
                if "home_here" in self.place.config:
                    await self._home_here()
                else:
                    seconds = float(self.place.config.get("homing_timeout", 120))
                    await self._recovered()
                    await self._clear_hold()
                    await home(self.controller, seconds, self._ended(goal))
                    await self._learn_again()
                    await self._learn_scale()
                    await self._step_inside()
                self._read_report()
                self._left = self._place_known()
        except Ended:
            raise self._ending(goal, "HomingFailed", "unknown") from None

    async def _learn_scale(self) -> None:
        """FluidNC's begins where its configuration says as it homes; another program may change that."""
        c = self.controller
        if c.kind.own_scale:
            c.settings = replace(c.settings, homes_at=await homes_at(c, c.settings.axes))
            self._lay_out()

    async def _step_inside(self) -> None:
        c = self.controller
        machine = (await c.look()).machine if self.soft_ends else None
        if machine is not None and (line := self._line_inside(machine)):
            await c.ask(line)
            await c.ask("G4P0")

    async def _runs(self) -> bool:
        return not self.controller.dead and (await self.controller.look()).state in ("Run", "Jog")

    async def _hold(self) -> None:
        if not self.controller.dead:
            # In Idle a hold would persist, and block the next line.
            self.controller.write(HOLD)
            await self._until(lambda r: r.state != "Run" and r.still, "did not come to a stop")

    async def _resume(self) -> None:
        if (await self.controller.look()).state in ("Hold", "Door"):
            # While it still brakes, GRBL drops a resume.
            await self._until(lambda r: not r.braking, "did not come to a stop")
            self.controller.write(RESUME)
            await self._until(lambda r: r.state not in ("Hold", "Door"), "did not resume")

    async def _stop(self) -> None:
        await stop(self.controller, moving=self._doing is not None)

    async def halt(self, goal: GoalContext) -> dict[str, Any]:
        await super().halt(goal)
        with self._telling("halt"):
            await wake(self.controller)
        return {}

    async def unlock(self, goal: GoalContext) -> dict[str, Any]:
        self._check_connected("unlock")
        c = self.controller
        with self._telling("unlock (`$X`)"):
            await self._recovered()
            locked = (await c.look()).state == "Alarm"
            if locked:
                await c.ask("$X")
            if locked or c.alarm:
                c.alarm, c.homed = "", False
            await c.look()
        return {}

    async def _reach(self) -> None:
        await reach(self.controller, float(self.place.config.get("boot_s", 3)))
        self._lay_out()
        self._read_report()

    def _lay_out(self) -> None:
        settings = self.controller.settings
        if "home_here" not in self.place.config:
            self.bench = read_bench(self.place.config, self.limits, settings.ranges)
        self._learn(settings)

    async def _learn_again(self) -> str:
        """Read its settings, which another program may have changed: what of its scale."""
        c = self.controller
        before, told = c.settings, {}
        for _ in range(READINGS):  # one that differs by noise alone is not told twice
            last, told = told, Settings.read(await c.ask("$$", SETTINGS_S)).values
            if told == before.values:
                return ""
            if told == last:
                break
        else:
            raise Silent(f"it does not tell its settings twice alike; {c.last_words}")
        settings = replace(before, values=told)
        if settings.unfit:
            raise MotionFault(settings.unfit)
        c.configure(settings)
        self._lay_out()
        await learn_offset(c)
        return settings.changed(before, SCALE)

    @property
    def _in_doubt(self) -> bool:
        """Whether it stands where it was not left: by another program, its settings, or noise in a report."""
        report = self.controller.report
        if report is None or report.state != "Idle" or self._doing or not self.controller.homed:
            return False
        return report.machine != self._left

    def _make_sure(self) -> "asyncio.Task[None]":
        """Read its settings and its place again; all who wait share one reading."""
        if self._sure is None or self._sure.done():
            name = f"reading the settings of {self.controller.port.name} again"
            self._sure = spawn(name, self._read_again(), expected=(MotionFault,), among=self._tasks)
        return self._sure

    async def _read_again(self) -> None:
        c = self.controller
        try:
            if changed := await self._learn_again():
                c.homed, c.alarm = False, changed_words(changed)
            self._left = await self._told_twice()
        except Refused:  # it has just begun to move
            return
        self._read_report()

    async def _told_twice(self) -> Point | None:
        """Its place by two reports alike: noise may have changed a digit of one."""
        c = self.controller
        if not c.settings.tells_machine:  # a damaged work offset would be in both
            await learn_offset(c, 2)
        report = await c.look()
        for _ in range(READINGS):
            before, report = report, await c.look()
            if report.machine == before.machine:
                break
        return report.machine

    async def _keep(self) -> None:
        """Reopen the port whenever it was lost; the gantry's position is then unknown."""
        c = self.controller
        while True:
            await c.until(lambda: bool(c.lost), 3600)
            if not c.lost:
                continue
            why = c.lost
            await c.port.close()
            await asyncio.sleep(AGAIN_S)
            c.alarm = f"the connection was lost ({why}) and is back. Home it"
            self._reattaching = True
            try:
                with contextlib.suppress(OSError):
                    await self._reach()
            finally:
                self._reattaching = False

    async def _home_here(self) -> None:
        c = self.controller
        report = await c.look()
        if report.state == "Alarm" or c.dead:
            raise MotionFault("it is locked by an alarm; unlock it, and put it back at its place")
        machine = report.machine
        if machine is None:
            raise Silent("it does not report where it is")
        self.bench = bench_from_here(self.place.config, self.limits, machine)
        c.homed, c.alarm = True, ""

    async def _clear_hold(self) -> None:
        """End a leftover hold, which would keep `$H` waiting forever."""
        c = self.controller
        if (await c.look()).state in ("Hold", "Door"):
            await stop(c, moving=False)
        await wake(c)

    async def _recovered(self) -> None:
        """After an alarm, wait until it responds again, and retry if recovery had given up."""
        c = self.controller
        if not c.dead:
            return
        if self._recovery is None or self._recovery.done():
            self._recover(1)
        assert self._recovery is not None
        await asyncio.wait({self._recovery})
        if c.dead:
            raise StillLocked(c.alarm)

    async def _find_out(self, tries: int) -> None:
        c = self.controller
        await recover(c, tries)
        if c.alarm == c.kind.alarm(SOFT_LIMIT) and not c.dead:
            with contextlib.suppress(MotionFault):
                told = replace(c.settings, values=Settings.read(await c.ask("$$")).values)
                c.alarm = out_of_travel_words(c.alarm, told.changed(c.settings, TRAVEL))

    async def _drive(self, goal: GoalContext, end: dict[int, float], feed: float | None) -> Point:
        with self._moving(goal, "move", end) as move:
            try:
                self._left = place = await move.go(self._move_line(end, feed), end)
            except WrongPlace as fault:
                with contextlib.suppress(MotionFault):
                    await asyncio.shield(self._make_sure())
                if self.controller.alarm:  # its scale is another one since the move began
                    raise WrongPlace(f"it has stopped, but {self.controller.alarm}") from fault
                raise
            except Alarmed as fault:
                if fault.code == SOFT_LIMIT:
                    await self._recovered()  # which finds out why
                    fault.args = (f"it answered {self.controller.alarm}",)
                raise
            return place

    async def _jog_by(self, goal: GoalContext, by: dict[int, float], feed: float) -> None:
        with self._moving(goal, "jog") as move:
            await jog_by(move, by, feed)

    async def _jog_while(
        self, goal: GoalContext, far: dict[int, float], feed: float, held: Callable[[], bool]
    ) -> None:
        with self._moving(goal, "jog") as move:
            await jog_while(move, far, feed, held)

    async def go_to_zero(
        self, goal: GoalContext, *, axes: list[str] | None = None, feed: float | None = None
    ) -> dict[str, Any]:
        if self.homed and not self.known.lost:
            with self._telling("tell its work zero", before=True):
                await learn_offset(self.controller, 2)
        return await super().go_to_zero(goal, axes=axes, feed=feed)

    async def _set_zero(self, axes: list[int]) -> None:
        c = self.controller
        await c.ask(zero_line(axes), 30.0)  # it waits for standstill, and writes to its slow memory
        await learn_offset(c)

    async def _probe(self, goal: GoalContext, axis: int, way: float, feed: float) -> Point | None:
        with self._moving(goal, "touch") as move:
            return self.controller.reports.contact(
                await move.touch(self._touch_line(axis, way, feed))
            )

    async def _carry_out(self, line: str) -> None:
        await self.controller.ask(line, 30.0)  # it waits for standstill

    async def _at_once(self, data: bytes) -> None:
        self.controller.write(data)

    def _pins(self) -> str:
        return self.controller.report.pins if self.controller.report else ""

    def _overrides(self) -> tuple[int, ...]:
        return self.controller.reports.overrides

    async def _machine(self) -> Point:
        report = await self.controller.look()
        if report.machine is None:
            raise Silent(
                "it has not reported its work offset, without which its reports give no position; "
                "`$10=1` makes it report machine positions"
            )
        return report.machine

    def _offset(self) -> Point | None:
        return self.controller.reports.offset

    @contextlib.contextmanager
    def _moving(self, goal: GoalContext, doing: str, end: dict[int, float] | None = None):
        """Wrap one motion: a stop or a cancel that ends it is reported as such."""
        told, self._left = _progress(goal, self._place_known(), end or {}), None
        with self._under_way(doing):
            try:
                yield Move(self.controller, self._ended(goal), lambda r: told(self, r))
            except (Ended, Restarted) as fault:
                if isinstance(fault, Restarted) and not self._ended(goal)():
                    raise
                raise self._ending(goal, "Alarm", "yes") from None
            except Lost as fault:
                raise Lost(
                    f"it stopped responding: {fault}. It may still finish what it was sent; "
                    f"plug it in again, and home it"
                ) from fault

    def _place_known(self) -> Point | None:
        return self.controller.report.machine if self.controller.report else None

    async def _until(self, true: Callable[[Report], bool], failing: str) -> None:
        clock = asyncio.get_running_loop().time
        end = clock() + HELD_S
        while not true(await self.controller.look()):
            if clock() > end:
                raise Silent(f"it {failing} within {HELD_S:g} s; {self.controller.last_words}")
            await asyncio.sleep(0.05)

    def _name(self) -> str:
        c = self.controller
        return f"{self.place.device} ({c.kind.name} on {c.port.name})"

    async def _look(self) -> Point | None:
        c = self.controller
        if c.dead:
            return None
        report = await c.look()
        if self._in_doubt or (c.homed and self._doing is None and _near_zero(report.machine)):
            await asyncio.shield(self._make_sure())
        return self._place_known()

    def _held_in(self) -> str:
        c = self.controller
        if c.report is None or c.report.state not in ("Hold", "Door", "Sleep", "Check"):
            return ""
        return c.report.state + (f" ({c.message})" if c.message.startswith("Check") else "")

    def _locked(self) -> bool:
        report = self.controller.report
        return report is not None and report.state == "Alarm"

    def _reported(self) -> None:
        if (machine := self._place_known()) is not None and not self._in_doubt:
            self._publish(machine)

    def _read_report(self) -> None:
        self._published = None
        self._reported()

    def _recover(self, tries: int = TRIES) -> None:
        name = f"recovering {self.controller.port.name} from an alarm"
        self._recovery = spawn(name, self._find_out(tries))
        self._tasks.add(self._recovery)
        self._recovery.add_done_callback(self._tasks.discard)


def _near_zero(machine: Point | None) -> bool:
    """Whether an axis stands where another scale would tell the same place."""
    return machine is not None and min(map(abs, machine[:3])) < NEAR_MM


def _progress(
    goal: GoalContext, start: Point | None, end: dict[int, float]
) -> Callable[[Grbl, Report], None]:
    """Report the move's progress to the goal."""

    def tell(gantry: Grbl, report: Report) -> None:
        if report.machine is None:
            return
        part = None
        if start is not None and end:
            whole = max(abs(value - start[axis]) for axis, value in end.items())
            gone = max(abs(report.machine[axis] - start[axis]) for axis in end)
            part = min(1.0, gone / whole) if whole else 1.0
        held = " (on hold)" if report.state in ("Hold", "Door") else ""
        goal.feedback(part, place_words(gantry.bench.to_bench(report.machine)) + held)

    return tell
