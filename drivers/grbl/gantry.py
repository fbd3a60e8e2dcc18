"""The gantry behind a GRBL or grblHAL controller, as a driver.

Configuration: `port` (`/dev/serial/by-id/...`, `COM5`, `socket://host:port`), `baud` (115200),
`origin`, `axes`, `keep_out`, `home_first`, `homing_timeout` (s), `home_here` (a machine without
switches), `boot_s` (how long the banner may take). `docs/how-to/gantry.md` explains each.
"""

import asyncio
import contextlib
from collections.abc import Callable
from typing import Any, ClassVar

from ..driver import ActionCanceled, ActionFailed, GoalContext, Place
from .alarm import recover
from .bench import Point, bench_from_here, read_bench, words
from .boot import reach
from .by_hand import ByHand
from .config import PLACING
from .controller import HOLD, RESUME, Controller
from .faults import GrblFault, Lost, NotConnected, Restarted, Silent, StillLocked
from .homing import home
from .jog import jog_by, jog_while
from .motion import Ended, Move
from .report import Report
from .stopping import finished, stop, wake
from .telling import state_of, trouble_of

AGAIN_S = 1.0
STATUS_S = 0.8
HELD_S = 3.0


class Grbl(ByHand):
    """Keeps gantry@1 by pyserial; the port comes back by itself after it was unplugged."""

    options: ClassVar[tuple[str, ...]] = ("port", "baud", "boot_s", "home_here", *PLACING)

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        if not place.config.get("port"):
            raise ValueError("config needs `port`, such as /dev/serial/by-id/usb-... or COM5")
        self.controller = Controller(
            str(place.config["port"]), int(place.config.get("baud", 115200))
        )
        self.controller.on_alarm = self._recover
        self.controller.on_report = self._reported
        self._tasks: set[asyncio.Task[None]] = set()
        self._recovery: asyncio.Task[None] | None = None
        self._doing: str | None = None
        self._stopped = False

    @property
    def homed(self) -> bool:
        return self.controller.homed

    async def open(self) -> None:
        await self._reach()
        self._start(self._keep())

    async def close(self) -> None:
        for task in list(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await finished(self.controller)
        self.controller.disconnected("it was closed")
        await self.controller.port.close()

    async def status(self) -> dict[str, Any]:
        c = self.controller
        if not (c.lost or c.dead or c.deaf or self._doing == "home"):
            with contextlib.suppress(GrblFault):
                await c.look(STATUS_S)
        told: dict[str, Any] = {
            "state": state_of(c, self._doing),
            "homed": c.homed,
            "alarm": trouble_of(c),
        }
        if c.report is not None and c.report.machine is not None:
            told |= {**self._place(c.report.machine), "feed": round(c.report.feed_mm_per_min, 3)}
            told |= self._from_zero(c.report.work)
        return told

    async def safe(self) -> None:
        self._stopped = True
        try:
            await stop(self.controller, moving=self._doing is not None)
        except GrblFault as fault:
            raise OSError(f"{self._name()}: {fault}") from fault

    async def home(self, goal: GoalContext) -> dict[str, Any]:
        self._check_connected("home")
        try:
            with self._under_way("home"):
                if "home_here" in self.place.config:
                    await self._home_here()
                else:
                    seconds = float(self.place.config.get("homing_timeout", 120))
                    await self._recovered()
                    await self._clear_hold()
                    await home(self.controller, seconds, self._ended(goal))
                self._read_report()
        except Ended:
            raise self._ending(goal, "HomingFailed", "unknown") from None
        except GrblFault as fault:
            error = "Offline" if isinstance(fault, NotConnected) else "HomingFailed"
            message = f"{self._name()} was asked to home (`$H`); {fault}"
            raise ActionFailed(error, message, fault.happened) from fault
        return {}

    async def hold(self, goal: GoalContext) -> dict[str, Any]:
        self._check_connected("hold")
        c = self.controller
        with self._telling("hold (`!`)"):
            if self._doing == "move" and not c.dead:
                # In Idle a hold would be kept, and block the next line.
                c.write(HOLD)
                await self._until(lambda r: r.state != "Run" and r.still, "did not come to a stand")
        return {}

    async def resume(self, goal: GoalContext) -> dict[str, Any]:
        self._check_connected("resume")
        with self._telling("resume (`~`)"):
            report = await self.controller.look()
            if report.state in ("Hold", "Door"):
                self.controller.write(RESUME)
                await self._until(lambda r: r.state not in ("Hold", "Door"), "did not go on")
        return {}

    async def halt(self, goal: GoalContext) -> dict[str, Any]:
        self._check_connected("halt")
        with self._telling("halt"):
            await stop(self.controller, moving=self._doing is not None)
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
        if "home_here" not in self.place.config:
            self.bench = read_bench(self.place.config, self.limits, self.controller.settings)
        self._read_report()

    async def _keep(self) -> None:
        """Take the port up again whenever it was lost; where the gantry stands is then unknown."""
        c = self.controller
        while True:
            await c.until(lambda: bool(c.lost), 3600)
            if not c.lost:
                continue
            why = c.lost
            await c.port.close()
            await asyncio.sleep(AGAIN_S)
            c.alarm = f"the connection was lost ({why}) and is back. Home it"
            with contextlib.suppress(OSError):
                await self._reach()

    async def _home_here(self) -> None:
        c = self.controller
        report = await c.look()
        if report.state == "Alarm" or c.dead:
            raise GrblFault("it is locked by an alarm; unlock it, and put it at its place again")
        machine = report.machine
        if machine is None:
            raise Silent("it does not say where it is")
        self.bench = bench_from_here(self.place.config, self.limits, machine)
        c.homed, c.alarm = True, ""

    async def _clear_hold(self) -> None:
        """A hold that was left would keep `$H` waiting for ever."""
        c = self.controller
        if (await c.look()).state in ("Hold", "Door"):
            await stop(c, moving=False)
        await wake(c)

    async def _recovered(self) -> None:
        """After an alarm: wait until it answers again, and try anew where it had given up."""
        c = self.controller
        if not c.dead:
            return
        if self._recovery is None or self._recovery.done():
            self._recovery = self._start(recover(c, 1))
        await asyncio.wait({self._recovery})
        if c.dead:
            raise StillLocked(c.alarm)

    async def _drive(self, goal: GoalContext, line: str, end: dict[int, float]) -> Point:
        with self._moving(goal, "move", end) as move:
            return await move.go(line, end)

    async def _jog_by(self, goal: GoalContext, axis: int, distance: float, feed: float) -> None:
        with self._moving(goal, "jog") as move:
            await jog_by(move, axis, distance, feed)

    async def _jog_while(
        self, goal: GoalContext, axis: int, way: float, feed: float, held: Callable[[], bool]
    ) -> None:
        with self._moving(goal, "jog") as move:
            await jog_while(move, axis, way, feed, held)

    async def _set_zero(self, line: str) -> None:
        c = self.controller
        await c.ask(line, 30.0)  # it waits for a standstill, and writes to its slow memory
        c.reports.offset = None
        for _ in range(40):
            await c.look()
            if c.reports.offset is not None:
                return
            await asyncio.sleep(0.01)

    async def _machine(self) -> Point:
        report = await self.controller.look()
        if report.machine is None:
            raise Silent(
                "it has not told its work offset, without which its report says no place; "
                "`$10=1` makes it tell the machine's own"
            )
        return report.machine

    def _offset(self) -> Point | None:
        return self.controller.reports.offset

    @contextlib.contextmanager
    def _under_way(self, doing: str):
        self._doing, self._stopped = doing, False
        try:
            yield
        finally:
            self._doing = None

    @contextlib.contextmanager
    def _moving(self, goal: GoalContext, doing: str, end: dict[int, float] | None = None):
        """Around one motion: a stop or a cancel that ends it is told as such."""
        start = self.controller.report.machine if self.controller.report else None
        told = _progress(goal, start, end or {})
        with self._under_way(doing):
            try:
                yield Move(self.controller, self._ended(goal), lambda r: told(self, r))
            except (Ended, Restarted) as fault:
                if isinstance(fault, Restarted) and not self._ended(goal)():
                    raise
                raise self._ending(goal, "Alarm", "yes") from None
            except Lost as fault:
                raise Lost(
                    f"it answered nothing more: {fault}. What it had been told it may do to its end; "
                    f"plug it in again, and home it"
                ) from fault

    def _ended(self, goal: GoalContext) -> Callable[[], bool]:
        return lambda: goal.cancelled.is_set() or self._stopped

    def _ending(self, goal: GoalContext, error: str, happened: Any) -> Exception:
        report = self.controller.report
        machine = report.machine if report else None
        where = words(self.bench.to_bench(machine)) if machine else "an unknown place"
        if goal.cancelled.is_set():
            return ActionCanceled(f"stopped at {where}")
        return ActionFailed(
            error, f"a stop ended the motion of {self._name()} at {where}", happened
        )

    async def _until(self, true: Callable[[Report], bool], failing: str) -> None:
        clock = asyncio.get_running_loop().time
        end = clock() + HELD_S
        while not true(await self.controller.look()):
            if clock() > end:
                raise Silent(f"it {failing} within {HELD_S:g} s; {self.controller.last_words}")
            await asyncio.sleep(0.05)

    def _name(self) -> str:
        kind = "grblHAL" if "HAL" in self.controller.firmware else "GRBL"
        return f"{self.place.device} ({kind} on {self.controller.port.name})"

    def _check_connected(self, asked: str) -> None:
        if self.controller.lost:
            raise ActionFailed(
                "Offline",
                f"{self._name()} was asked to {asked}, but {self.controller.lost}; "
                f"it is taken up again when it is back",
                "no",
            )

    def _in_alarm(self) -> bool:
        c = self.controller
        return bool(c.alarm) or (c.report is not None and c.report.state == "Alarm")

    async def _ready(self) -> None:
        c = self.controller
        self._check_connected("move")
        if not c.dead:
            with self._telling("say how it is (`?`)", before=True):
                await c.look()
        if c.alarm:
            raise ActionFailed("Alarm", f"{self._name()} was not moved: {c.alarm}", "no")
        if c.report is not None and c.report.state in ("Hold", "Door", "Sleep", "Check"):
            why = f" ({c.message})" if c.message.startswith("Check") else ""
            words = f"it is in the state {c.report.state}{why}; resume it, or halt it first"
            raise ActionFailed("Held", f"{self._name()} was not moved: {words}", "no")

    def _locked(self) -> bool:
        report = self.controller.report
        return report is not None and report.state == "Alarm"

    def _reported(self) -> None:
        report = self.controller.report
        if report is not None and report.machine is not None:
            self._publish(report.machine)

    def _read_report(self) -> None:
        self._published = None
        self._reported()

    def _recover(self) -> None:
        self._recovery = self._start(recover(self.controller))

    def _start(self, work: Any) -> asyncio.Task[None]:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task


def _progress(
    goal: GoalContext, start: Point | None, end: dict[int, float]
) -> Callable[[Grbl, Report], None]:
    """Tells the goal how far the move is."""

    def tell(gantry: Grbl, report: Report) -> None:
        if report.machine is None:
            return
        part = None
        if start is not None and end:
            whole = max(abs(value - start[axis]) for axis, value in end.items())
            gone = max(abs(report.machine[axis] - start[axis]) for axis in end)
            part = min(1.0, gone / whole) if whole else 1.0
        held = " (on hold)" if report.state in ("Hold", "Door") else ""
        goal.feedback(part, words(gantry.bench.to_bench(report.machine)) + held)

    return tell
