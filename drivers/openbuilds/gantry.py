"""The gantry behind OpenBuilds CONTROL, as a driver.

Configuration: `url` (http://localhost:3000), `port` (the serial port, as CONTROL calls it) and
`baud`, or `ip` (a controller by telnet), `origin`, `axes`, `keep_out`, `home_first`,
`homing_timeout` (s). `docs/how-to/gantry.md` explains each.
"""

import asyncio
import contextlib
from collections.abc import Callable, Iterator
from typing import Any, ClassVar

from ..driver import ActionCanceled, ActionFailed, GoalContext, Place
from ..grbl.bench import Point, read_bench, words
from ..grbl.by_hand import ByHand
from ..grbl.config import PLACING
from ..grbl.faults import GrblFault, Lost, NotConnected, Silent
from ..grbl.motion import WrongPlace
from ..grbl.settings import Settings
from .control import Control
from .jog import jog_while
from .stopping import stop
from .view import ALARM, PAUSED, PLAYING, View
from .watch import Ended, watch

SETTINGS_S = 3.0
AGAIN_S = 3.0
THERE_S = 3.0  # the position is told up to 0.9 s late
ZERO_S = 10.0  # the offset comes with every 30th report, five of them a second
HELD_S = 3.0


class OpenBuilds(ByHand):
    """Keeps gantry@1 over CONTROL's Socket.IO; comes back by itself when CONTROL or the port do."""

    options: ClassVar[tuple[str, ...]] = ("url", "port", "baud", "ip", *PLACING)

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        config = place.config
        if not config.get("port") and not config.get("ip"):
            raise ValueError("config needs `port`, such as /dev/ttyUSB0 or COM5, or `ip`")
        usb = {"type": "usb", "port": config.get("port"), "baud": int(config.get("baud", 115200))}
        telnet = {"type": "telnet", "ip": config.get("ip")}
        self.control = Control(
            str(config.get("url", "http://localhost:3000")), telnet if config.get("ip") else usb
        )
        self.tolerance = Settings().tolerance
        self._keeper: asyncio.Task[None] | None = None
        self._doing: str | None = None
        self._stopped = False

    @property
    def homed(self) -> bool:
        return self.control.homed

    async def open(self) -> None:
        await self.control.open()
        try:
            await self._attach()
        except BaseException:
            await self.control.close()
            raise
        self._keeper = asyncio.create_task(self._keep())

    async def close(self) -> None:
        if self._keeper is not None:
            self._keeper.cancel()
            await asyncio.gather(self._keeper, return_exceptions=True)
        await self.control.close()

    async def status(self) -> dict[str, Any]:
        view = self.control.view
        told: dict[str, Any] = {
            "state": self._state(),
            "homed": self.homed,
            "alarm": self.control.lost or self.control.alarm or self._locked_words(),
        }
        if view is not None:
            self._publish(view.machine)
            told |= self._place(view.machine) | self._from_zero(view.work)
        return told

    async def safe(self) -> None:
        self._stopped = True
        try:
            await stop(self.control, moving=self._doing is not None, homing=self._doing == "home")
        except GrblFault as fault:
            raise OSError(f"{self._name()}: {fault}") from fault

    async def home(self, goal: GoalContext) -> dict[str, Any]:
        self._check_connected("home")
        control = self.control
        try:
            with self._moving(goal, "home"):
                if control.view is not None and control.view.connection == ALARM:
                    await self._clear()
                control.homed = False
                answer = await control.run("$H")
                seconds = float(self.place.config.get("homing_timeout", 120))
                await watch(control, answer, self._ended(goal), seconds=seconds)
                control.homed, control.alarm = True, ""
                control.unsettle()
                await control.settled()
        except GrblFault as fault:
            error = "Offline" if isinstance(fault, NotConnected) else "HomingFailed"
            message = f"{self._name()} was asked to home (`$H`); {fault}"
            raise ActionFailed(error, message, fault.happened) from fault
        return {}

    async def hold(self, goal: GoalContext) -> dict[str, Any]:
        self._check_connected("hold")
        with self._telling("hold (`!`)"):
            if self._doing == "move":
                # CONTROL's own pause is for jobs, and does nothing for a command.
                await self._inject("!", lambda view: view.held or self._doing is None)
        return {}

    async def resume(self, goal: GoalContext) -> dict[str, Any]:
        self._check_connected("resume")
        with self._telling("resume (`~`)"):
            if self.control.look().run.startswith(("Hold", "Door", "Paused")):
                await self._inject("~", lambda view: not view.run.startswith(("Hold", "Door")))
        return {}

    async def halt(self, goal: GoalContext) -> dict[str, Any]:
        self._check_connected("halt")
        with self._telling("halt"):
            await stop(self.control, moving=self._doing is not None)
        return {}

    async def unlock(self, goal: GoalContext) -> dict[str, Any]:
        self._check_connected("unlock")
        with self._telling("unlock"):
            if self.control.locked or self.control.alarm:
                await self._clear()
        return {}

    async def _attach(self) -> None:
        """The port open in CONTROL, and the machine's settings read."""
        control = self.control
        await control.attach()
        if control.look().connection in (PLAYING, PAUSED):
            raise OSError(
                f"{self._name()} is running a job of its own; let it end or stop it in the program"
            )
        try:
            await self._ask_settings()
        except GrblFault as fault:
            if "130" not in control.settings:
                raise OSError(
                    f"{self._name()} does not tell its settings (`$$`): {fault}"
                ) from fault
        lines = [f"{number}={value}" for number, value in control.settings.items()]
        settings = Settings.read(lines, control.look().options)
        self.bench = read_bench(self.place.config, self.limits, settings)
        self.tolerance = settings.tolerance
        control.unsettle()  # opening the port has booted the controller
        with contextlib.suppress(Lost):
            await control.settled()

    async def _ask_settings(self) -> None:
        """`$$` waits behind a move that an earlier life of this server began: that is stopped."""
        try:
            await self.control.ask("$$", SETTINGS_S)
        except Silent:
            await stop(self.control, moving=True)
            await self.control.ask("$$", SETTINGS_S)

    async def _keep(self) -> None:
        """Have CONTROL open the port again when it was lost, or CONTROL was started anew."""
        control = self.control
        while True:
            await asyncio.sleep(AGAIN_S)
            if control.lost and not control.disconnected:
                control.homed = False
                control.alarm = control.alarm or "the port was lost and is back. Home it"
                with contextlib.suppress(OSError, GrblFault):
                    await self._attach()

    async def _clear(self) -> None:
        """Queue dropped, reset, unlocked. A reset right after an alarm would be swallowed."""
        control = self.control
        since = asyncio.get_running_loop().time() - control.alarm_at
        await asyncio.sleep(max(0.0, 1.0 - since))
        await control.emit("clearAlarm", 2)
        await asyncio.sleep(1.0)
        if not await control.until(lambda: control.clear, HELD_S):
            view = control.view
            told = f"it still says {view.run}" if view else "it says nothing"
            raise GrblFault(f"{told}; look whether a switch or the emergency stop is pressed")
        control.alarm, control.homed = "", False

    async def _drive(self, goal: GoalContext, line: str, end: dict[int, float]) -> Point:
        control = self.control
        with self._moving(goal, "move"):
            await watch(control, await control.run(line), self._ended(goal), self._told(goal))
            return await self._verified(end)

    async def _verified(self, end: dict[int, float]) -> Point:
        """The place, told late: it is waited for."""
        if await self.control.until(lambda: self._there(end), THERE_S):
            return self.control.look().machine
        machine = self.control.look().machine
        found = " ".join(f"{'XYZ'[a]} {machine[a]:.3f}" for a in sorted(end))
        wanted = " ".join(f"{'XYZ'[a]} {v:.3f}" for a, v in sorted(end.items()))
        raise WrongPlace(f"it stands still, but at {found} in place of {wanted} (machine)")

    def _there(self, end: dict[int, float]) -> bool:
        machine = self.control.look().machine
        return all(abs(machine[axis] - value) <= self.tolerance for axis, value in end.items())

    async def _jog_by(self, goal: GoalContext, axis: int, distance: float, feed: float) -> None:
        # No `$J`: a `G4 P0` after it would be refused as long as it goes on, and stop the queue.
        lines = f"G21G91G94G1{'XYZ'[axis]}{distance:.4f}F{feed:.3f}", "G90"
        with self._moving(goal, "jog"):
            start = (await self.control.settled()).machine[axis]
            await watch(self.control, await self.control.run(*lines), self._ended(goal))
            self.control.unsettle()
            end = await self.control.settled()
            if self.homed and abs(end.machine[axis] - start - distance) > 2 * self.tolerance:
                raise WrongPlace(f"it went {end.machine[axis] - start:.3f} mm, not {distance:.3f}")

    async def _jog_while(
        self, goal: GoalContext, axis: int, way: float, feed: float, held: Callable[[], bool]
    ) -> None:
        with self._moving(goal, "jog"):
            await jog_while(self.control, axis, way, feed, held, self._ended(goal))

    async def _set_zero(self, line: str) -> None:
        control = self.control
        answer = await control.run(line)
        await watch(control, answer, lambda: False, seconds=30.0)
        axes = ["XYZ".index(letter) for letter in line if letter in "XYZ"]
        await control.until(
            lambda: all(abs(control.look().work[axis]) <= self.tolerance for axis in axes), ZERO_S
        )

    async def _machine(self) -> Point:
        return (await self.control.settled()).machine

    def _offset(self) -> Point | None:
        return self.control.view.offset if self.control.view else None

    async def _inject(self, byte: str, true: Callable[[View], bool]) -> None:
        await self.control.emit("serialInject", byte)
        await self._until(true, HELD_S)

    async def _until(self, true: Callable[[View], bool], seconds: float) -> None:
        control = self.control
        if not await control.until(lambda: true(control.look()), seconds):
            raise Silent(f"it says {control.look().run} after {seconds:.0f} s")

    @contextlib.contextmanager
    def _moving(self, goal: GoalContext, doing: str) -> Iterator[None]:
        """Around one motion: a stop or a cancel that ends it is told as such."""
        self._doing, self._stopped = doing, False
        try:
            yield
        except Ended:
            raise self._ending(goal, doing) from None
        except Lost as fault:
            if self._ended(goal)():
                raise self._ending(goal, doing) from fault
            raise Lost(
                f"{fault}. What the controller had been told it may do to its end"
            ) from fault
        finally:
            self._doing = None

    def _ending(self, goal: GoalContext, doing: str) -> Exception:
        view = self.control.view
        where = words(self.bench.to_bench(view.machine)) if view else "an unknown place"
        if goal.cancelled.is_set():
            return ActionCanceled(f"stopped at {where}")
        error = "HomingFailed" if doing == "home" else "Alarm"
        return ActionFailed(error, f"a stop ended the motion of {self._name()} at {where}", "yes")

    def _ended(self, goal: GoalContext) -> Callable[[], bool]:
        return lambda: goal.cancelled.is_set() or self._stopped

    def _told(self, goal: GoalContext) -> Callable[[View], None]:
        def tell(view: View) -> None:
            self._publish(view.machine)
            held = " (on hold)" if view.held else ""
            goal.feedback(None, words(self.bench.to_bench(view.machine)) + held)

        return tell

    def _name(self) -> str:
        return f"{self.place.device} (OpenBuilds CONTROL at {self.control.url})"

    def _check_connected(self, asked: str) -> None:
        if self.control.lost:
            message = f"{self._name()} was asked to {asked}, but {self.control.lost}"
            raise ActionFailed("Offline", message, "no")

    def _in_alarm(self) -> bool:
        return bool(self.control.alarm) or self.control.locked

    async def _ready(self) -> None:
        self._check_connected("move")
        if self.control.alarm:
            message = f"{self._name()} was not moved: {self.control.alarm}"
            raise ActionFailed("Alarm", message, "no")
        run = self.control.look().run
        if run.startswith(("Hold", "Door", "Sleep", "Check", "Paused")):
            words_ = f"it is in the state {run}; resume it, or halt it first"
            raise ActionFailed("Held", f"{self._name()} was not moved: {words_}", "no")

    def _locked(self) -> bool:
        return self.control.locked

    def _locked_words(self) -> str:
        locked = "it is locked until it is homed (or unlocked, without a known place)"
        return locked if self.control.locked else ""

    def _state(self) -> str:
        control = self.control
        if control.lost or control.view is None:
            return "offline"
        if self._doing == "home":
            return "homing"
        if control.alarm or control.locked:
            return "alarm"
        if control.view.run.startswith(("Hold", "Door", "Paused")):
            return "hold"
        # Idle is told while it still moves: what we have begun and not seen ended is moving.
        return "moving" if self._doing or control.view.run in ("Run", "Jog", "Running") else "idle"
