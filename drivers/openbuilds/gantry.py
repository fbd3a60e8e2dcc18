"""The gantry behind OpenBuilds CONTROL, as a driver.

Configuration: `url` (http://localhost:3000), `port` (the serial port, as CONTROL calls it) and
`baud`, or `ip` (a controller by telnet), `origin`, `axes`, `keep_out`, `home_first`,
`homing_timeout`, `silence_s`, `boot_s` (s). `docs/how-to/gantry.md` explains each.
"""

import asyncio
import contextlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, ClassVar

from ...system.tasks import end, keep
from ..driver import GoalContext, Place
from ..grbl.dialect import GrblDialect, changed_words, out_of_travel_words, zero_line
from ..grbl.faults import SOFT_LIMIT
from ..grbl.jog import words_of
from ..grbl.report import ReportReader
from ..grbl.settings import SCALE, TRAVEL, Settings, homes_at_of
from ..motion.bench import LETTERS, Point, place_words, read_bench
from ..motion.config import PLACING
from ..motion.faults import Ended, HomingFailed, Lost, MotionFault, Restarted, Silent, WrongPlace
from .control import Control
from .jog import jog_while
from .stopping import stop
from .view import ALARM, PAUSED, PLAYING, View
from .watch import watch

SETTINGS_S = 3.0
SETTINGS_TRIES = 6
CONFIGURATION_S = 10.0
AGAIN_S = 3.0
THERE_S = 3.0  # the position is reported up to 0.9 s late
ZERO_S = 10.0  # the offset comes with every 30th report, five of them a second
HELD_S = 3.0
UNLOCK, RESET = 1, 2
"""What CONTROL's `clearAlarm` does: `$X`, or a reset that drops its queue, and `$X`."""
SILENCE_S = 2.0  # CONTROL sends ten statuses a second
BOOT_S = 10.0


class OpenBuilds(GrblDialect):
    """Implements gantry@2 over CONTROL's Socket.IO; reconnects when CONTROL or the port are back."""

    options: ClassVar[tuple[str, ...]] = (
        "url",
        "port",
        "baud",
        "ip",
        "silence_s",
        "boot_s",
        *PLACING,
    )

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        config = place.config
        if not config.get("port") and not config.get("ip"):
            raise ValueError("config needs `port`, such as /dev/ttyUSB0 or COM5, or `ip`")
        usb = {"type": "usb", "port": config.get("port"), "baud": int(config.get("baud", 115200))}
        telnet = {"type": "telnet", "ip": config.get("ip")}
        self.known = self.control = Control(
            str(config.get("url", "http://localhost:3000")),
            telnet if config.get("ip") else usb,
            float(config.get("silence_s", SILENCE_S)),
            float(config.get("boot_s", BOOT_S)),
        )
        self.alone = f"OpenBuilds CONTROL at {self.control.url}"
        self._keeper: asyncio.Task[None] | None = None
        self._settings = Settings()

    async def open(self) -> None:
        await self.control.open()
        try:
            await self._attach()
        except BaseException as fault:  # a cancel as well
            await self.control.close()
            if isinstance(fault, MotionFault):
                raise OSError(f"{self._name()}: {fault}") from fault
            raise
        self._keeper = keep(f"reattaching to {self.control.url}", self._keep)

    async def close(self) -> None:
        await end(self._keeper)
        await self.control.close()

    async def status(self) -> dict[str, Any]:
        view = self.control.view
        self._notice_settings()
        told: dict[str, Any] = {
            "state": self._state(),
            "homed": self.homed,
            "alarm": self.control.lost or self.control.alarm or self._locked_words(),
        }
        if view is not None:
            self._publish(view.machine)
            told |= self._standing(view.machine, view.work) | self._more_status(view.machine)
        return told

    async def _stop(self) -> None:
        await stop(self.control, moving=self._doing is not None, homing=self._doing == "home")

    async def _home(self, goal: GoalContext) -> None:
        control = self.control
        with self._moving(goal, "home"):
            if control.view is not None and control.view.connection == ALARM:
                await self._clear()
            control.homed = False
            answer = await control.run("$H")
            seconds = float(self.place.config.get("homing_timeout", 120))
            late = HomingFailed.too_long(seconds)
            await watch(control, answer, self._ended(goal), seconds=seconds, late=late)
            await control.ask("$$", SETTINGS_S)
            settings = await self._with_scale(self._told_settings())
            if unfit := _unfit(settings):
                raise MotionFault(unfit)
            self._lay_out(settings)
            control.homed, control.alarm = True, ""
            control.unsettle()
            if line := self._line_inside((await control.view_at_rest()).machine):
                await watch(control, await control.run(line), self._ended(goal))
                control.unsettle()
                await control.view_at_rest()

    async def _hold(self) -> None:
        # CONTROL's own pause is for jobs, and has no effect on a command.
        await self._inject("!", lambda view: view.held or (self._doing is None and view.still))

    async def _runs(self) -> bool:
        view = self.control.look()
        return not (view.still or view.held)

    async def _resume(self) -> None:
        if self.control.look().run.startswith(("Hold", "Door", "Paused")):
            await self._inject("~", lambda view: not view.run.startswith(("Hold", "Door")))

    async def unlock(self, goal: GoalContext) -> dict[str, Any]:
        self._check_connected("unlock")
        with self._telling("unlock"):
            if self.control.locked or self.control.alarm:
                await self._clear()
        return {}

    async def _attach(self) -> None:
        """Open the port in CONTROL, and read the machine's settings."""
        control = self.control
        await control.attach()
        if control.view is not None and control.view.connection in (PLAYING, PAUSED):
            raise OSError(
                f"{self._name()} is running another job; let it finish or stop it in the program"
            )
        await control.first_report()
        try:
            await self._ask_settings()
        except MotionFault as fault:
            if "130" not in control.settings:
                raise OSError(
                    f"{self._name()} does not report its settings (`$$`): {fault}"
                ) from fault
        settings = await self._with_scale(self._told_settings())
        if unfit := _unfit(settings):
            raise OSError(f"{self._name()}: {unfit}")
        self._lay_out(settings)
        control.unsettle()  # opening the port has booted the controller
        with contextlib.suppress(Lost):
            await control.view_at_rest()

    async def _with_scale(self, settings: Settings) -> Settings:
        """FluidNC's begins where its configuration says as it homes; another program may change that."""
        if not settings.firmware.own_scale:
            return settings
        return replace(settings, homes_at=homes_at_of(await self._ask_configuration()))

    def _told_settings(self) -> Settings:
        """As the controller told them last, to whichever program has asked."""
        control = self.control
        lines = [f"{number}={value}" for number, value in control.settings.items()]
        settings = Settings.read(lines, control.look().options, control.kind)
        return replace(settings, homes_at=self._settings.homes_at)

    def _lay_out(self, settings: Settings) -> None:
        self._settings = settings
        self.bench = read_bench(self.place.config, self.limits, settings.ranges)
        self._learn(settings)

    async def _ask_settings(self) -> None:
        """Stop a move that an earlier server began: `$$` would wait behind it.

        A board that still boots loses what it is sent, and CONTROL goes on waiting for its `ok`; since
        an alarm it sends nothing.
        """
        for left in reversed(range(SETTINGS_TRIES)):
            try:
                return await self.control.ask("$$", SETTINGS_S)
            except MotionFault as fault:
                if not left or isinstance(fault, Lost):
                    raise
                if not isinstance(fault, Restarted):  # that is what opening the port does
                    await self._empty_the_queue()
        return None

    async def _ask_configuration(self) -> str:
        """FluidNC's own; a question for one axis is answered by an error where it does not home."""
        control = self.control
        control.configuration = ""
        with self._telling("tell its configuration (`$CD`)"):
            await control.ask("$CD", CONFIGURATION_S)
            await control.until(lambda: bool(control.configuration), SETTINGS_S)
        return control.configuration

    async def _empty_the_queue(self) -> None:
        before = self.control.boots
        await stop(self.control, moving=True)
        if self.control.boots == before:  # it is locked, and was let be
            await self.control.drop()
            await self.control.until(lambda: self.control.boots > before, SETTINGS_S)

    async def _keep(self) -> None:
        """Make CONTROL reopen the port when it was lost, or CONTROL was restarted."""
        control = self.control
        while True:
            await asyncio.sleep(AGAIN_S)
            if control.lost and not control.disconnected:
                control.homed = False
                control.alarm = control.alarm or "the port was lost and is back. Home it"
                self._reattaching = True  # the board boots, and loses what is sent
                try:
                    with contextlib.suppress(OSError, MotionFault):
                        await self._attach()
                finally:
                    self._reattaching = False

    async def _clear(self) -> None:
        """Clear the queue, reset, unlock. A reset right after an alarm would be ignored.

        CONTROL unlocks half a second after the reset; a board that boots for longer loses that.
        """
        control = self.control
        since = asyncio.get_running_loop().time() - control.alarm_at
        await asyncio.sleep(max(0.0, 1.0 - since))
        boots = control.boots
        await control.emit("clearAlarm", RESET)
        await control.until(lambda: control.boots > boots, HELD_S)
        await asyncio.sleep(1.0)
        if control.locked and control.boots > boots:
            await control.emit("clearAlarm", UNLOCK)
        if not await control.until(lambda: control.clear, HELD_S):
            view = control.view
            told = f"it still reports {view.run}" if view else "it is silent"
            raise MotionFault(f"{told}; check whether a switch or the emergency stop is pressed")
        control.alarm, control.homed = "", False

    async def _drive(self, goal: GoalContext, end: dict[int, float], feed: float | None) -> Point:
        control = self.control
        with self._moving(goal, "move"):
            line = self._move_line(end, feed)
            await watch(control, await control.run(line), self._ended(goal), self._told(goal))
            return await self._verified(end)

    async def _verified(self, end: dict[int, float]) -> Point:
        """Wait for the final position, which is reported late."""
        control = self.control
        if await control.until(lambda: bool(control.alarm) or self._there(end), THERE_S):
            if control.alarm:
                raise MotionFault(control.alarm)
            return control.look().machine
        machine = self.control.look().machine
        found = " ".join(f"{LETTERS[a]} {machine[a]:.3f}" for a in sorted(end))
        wanted = " ".join(f"{LETTERS[a]} {v:.3f}" for a, v in sorted(end.items()))
        raise WrongPlace(f"it has stopped, but at {found} instead of {wanted} (machine)")

    def _there(self, end: dict[int, float]) -> bool:
        machine = self.control.look().machine
        return all(abs(machine[axis] - value) <= self.tolerance for axis, value in end.items())

    async def _jog_by(self, goal: GoalContext, by: dict[int, float], feed: float) -> None:
        # No `$J`: a `G4 P0` after it would be refused while it lasts, and halt the queue.
        lines = f"G21G91G94G1{words_of(by)}F{feed:.3f}", "G90"
        with self._moving(goal, "jog"):
            start = (await self.control.view_at_rest()).machine
            await watch(self.control, await self.control.run(*lines), self._ended(goal))
            self.control.unsettle()
            end = (await self.control.view_at_rest()).machine
            for axis, distance in by.items():
                moved = end[axis] - start[axis]
                if self.homed and abs(moved - distance) > 2 * self.tolerance:
                    raise WrongPlace(f"{LETTERS[axis]} moved {moved:.3f} mm, not {distance:.3f}")

    async def _jog_while(
        self, goal: GoalContext, far: dict[int, float], feed: float, held: Callable[[], bool]
    ) -> None:
        with self._moving(goal, "jog"):
            await jog_while(self.control, far, feed, held, self._ended(goal))

    async def _set_zero(self, axes: list[int]) -> None:
        control = self.control
        answer = await control.run(zero_line(axes))
        await watch(control, answer, lambda: False, seconds=30.0)
        await control.until(
            lambda: all(abs(control.look().work[axis]) <= self.tolerance for axis in axes), ZERO_S
        )

    async def _probe(self, goal: GoalContext, axis: int, way: float, feed: float) -> Point | None:
        control = self.control
        control.probed.clear()
        with self._moving(goal, "touch"):
            answer = await control.run(self._touch_line(axis, way, feed), "G90")
            await watch(control, answer, self._ended(goal), self._told(goal))
            control.unsettle()
            return ReportReader().contact(control.probed)

    async def _carry_out(self, line: str) -> None:
        await watch(self.control, await self.control.run(line), lambda: False, seconds=30.0)

    async def _at_once(self, data: bytes) -> None:
        for (
            byte
        ) in data:  # CONTROL sends text as UTF-8: the byte before each is one that GRBL ignores
            await self.control.emit("serialInject", chr(byte))

    def _pins(self) -> str:
        return self.control.view.pins if self.control.view else ""

    def _overrides(self) -> tuple[int, ...]:
        return self.control.view.overrides if self.control.view else ()

    async def _machine(self) -> Point:
        return (await self.control.view_at_rest()).machine

    def _offset(self) -> Point | None:
        return self.control.view.offset if self.control.view else None

    async def _inject(self, byte: str, true: Callable[[View], bool]) -> None:
        await self.control.emit("serialInject", byte)
        await self._until(true, HELD_S)

    async def _until(self, true: Callable[[View], bool], seconds: float) -> None:
        control = self.control
        if not await control.until(lambda: true(control.look()), seconds):
            raise Silent(f"it reports {control.look().run} after {seconds:.0f} s")

    @contextlib.contextmanager
    def _moving(self, goal: GoalContext, doing: str) -> Iterator[None]:
        """Wrap one motion: a stop or a cancel that ends it is reported as such."""
        error = "HomingFailed" if doing == "home" else "Alarm"
        with self._under_way(doing):
            try:
                yield
            except Ended:
                raise self._ending(goal, error, "yes") from None
            except Lost as fault:
                raise Lost(f"{fault}. The controller may still finish what it was sent") from fault

    def _place_known(self) -> Point | None:
        return self.control.view.machine if self.control.view else None

    def _told(self, goal: GoalContext) -> Callable[[View], None]:
        def tell(view: View) -> None:
            self._publish(view.machine)
            held = " (on hold)" if view.held else ""
            goal.feedback(None, place_words(self.bench.to_bench(view.machine)) + held)

        return tell

    def _name(self) -> str:
        return f"{self.place.device} (OpenBuilds CONTROL at {self.control.url})"

    async def _look(self) -> None:
        """CONTROL reports ten times a second, without being asked."""
        self._notice_settings()

    def _notice_settings(self) -> None:
        """CONTROL tells every line that it was answered, whoever has sent it."""
        control = self.control
        if control.lost:
            return
        told = self._told_settings()
        if control.homed and (changed := told.changed(self._settings, SCALE)):
            control.homed = False
            control.alarm = _unfit(told) or changed_words(changed)
        if control.alarm == control.kind.alarm(SOFT_LIMIT):
            changed = told.changed(self._settings, TRAVEL)
            control.alarm = out_of_travel_words(control.alarm, changed)

    def _held_in(self) -> str:
        run = self.control.look().run
        held = run.startswith(("Hold", "Door", "Sleep", "Check", "Paused"))
        return run if held else ""

    def _locked(self) -> bool:
        return self.control.locked

    def _locked_words(self) -> str:
        locked = "it is locked until it is homed (or unlocked, without a known position)"
        return locked if self.control.locked else ""

    def _state(self) -> str:
        control = self.control
        if control.lost or control.view is None or self._reattaching:
            return "offline"
        if self._doing == "home":
            return "homing"
        if control.alarm or control.locked:
            return "alarm"
        if control.view.run.startswith(("Hold", "Door", "Paused")):
            return "hold"
        # Idle is reported while it still moves: what we have begun and not seen ended is moving.
        return "moving" if self._doing or not control.view.still else "idle"


def _unfit(settings: Settings) -> str:
    """Why no move can be verified with these settings, and what to write; empty if nothing is wrong."""
    if settings.inches:
        return (
            "it reports in inches ($13=1), which CONTROL takes for mm: write `$13=0`, then home it"
        )
    return settings.unfit
