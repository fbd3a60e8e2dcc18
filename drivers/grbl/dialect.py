"""What GRBL's lines and real-time bytes say, whatever carries them."""

import asyncio
from abc import abstractmethod

from ..driver import ActionFailed, GoalContext
from ..motion.bench import LETTERS, Point
from ..motion.faults import MotionFault
from ..motion.jog_rules import JogRules
from .settings import Settings

MODES = "G21G90G94"
"""Millimetres, absolute, per minute: in every line, since a reset or another program may unset it."""
OVERRIDE_LOOKS, OVERRIDE_S = 20, (0.03, 0.1, 0.3)
"""Seconds from one real-time byte to the next: longer, where the report shows that some were lost."""


def changed_words(changed: str) -> str:
    return f"another program has changed {changed}, so its place is not known; home it"


def out_of_travel_words(alarm: str, changed: str) -> str:
    """A soft limit's alarm, with what another program has changed of the travel, if it has."""
    return (
        f"{alarm}. Another program has changed {changed}, and homing reads it" if changed else alarm
    )


class GrblDialect(JogRules):
    """A gantry behind GRBL, over a serial port or through OpenBuilds CONTROL."""

    laser_mode = False
    soft_ends: tuple[tuple[float, float], ...] = ()
    """Of each axis, where the controller's own soft limits end within its travel."""

    _reattaching = False

    def _check_connected(self, asked: str) -> None:
        """A board that boots loses what it is sent; one that does not is reset a moment later."""
        if self._reattaching and asked not in ("hold", "halt"):
            words = f"{self._name()} was asked to {asked}, but its port is being opened again"
            raise ActionFailed("Offline", words, "no")
        super()._check_connected(asked)

    def _learn(self, settings: Settings) -> None:
        """What its settings say beside the ranges."""
        self.soft_ends = settings.ranges if settings.soft_off_both_ends else ()
        self.full_power, self.tolerance = settings.full_power, settings.tolerance
        self.laser_mode = settings.laser_mode

    async def _switch(self, goal: GoalContext, output: str, on: bool, power: float) -> None:
        if on and self.laser_mode and self.outputs[output].has_power:
            raise ActionFailed(
                "NotAvailable",
                f"{self._name()} is in laser mode ($32=1), in which {output} stays dark while it stands, "
                f"though it answers `ok`: write $32=0; or, for one that is to shine in moves with `feed` "
                f"only, write it as lines, {output}: {{on: M3 S{self.full_power:g}, off: M5}}",
                "no",
            )
        await super()._switch(goal, output, on, power)

    @abstractmethod
    async def _at_once(self, data: bytes) -> None:
        """Send bytes that take effect at once; raises MotionFault."""

    def _move_line(self, end: dict[int, float], feed: float | None) -> str:
        words = "".join(f"{LETTERS[axis]}{value:.4f}" for axis, value in sorted(end.items()))
        return f"{MODES}G53G0{words}" if feed is None else f"{MODES}G53G1{words}F{feed:.3f}"

    def _line_inside(self, machine: Point) -> str:
        """grblHAL may have homed half a step outside its own soft limits: then no axis moves alone."""
        ends = zip(machine, self.soft_ends, strict=False)
        inside = {axis: min(max(at, low), high) for axis, (at, (low, high)) in enumerate(ends)}
        out = {axis: value for axis, value in inside.items() if value != machine[axis]}
        return self._move_line(out, None) if out else ""

    def _touch_line(self, axis: int, way: float, feed: float) -> str:
        return f"G21G91G94G38.3{LETTERS[axis]}{way:.4f}F{feed:.3f}"

    async def _override(self, feed: int | None, rapid: int | None) -> None:
        wanted = (feed, rapid)
        for pause_s in OVERRIDE_S:
            for byte in override_bytes(feed, rapid):
                await self._at_once(bytes([byte]))
                # Each sets a flag: two of one kind before GRBL has looked are one.
                await self._look()
                await asyncio.sleep(pause_s)
            for _ in range(OVERRIDE_LOOKS):
                await self._look()
                told = self._overrides()[:2]
                if all(w in (None, t) for w, t in zip(wanted, told, strict=False)) and told:
                    return
                await asyncio.sleep(OVERRIDE_S[0])
        raise MotionFault(f"it reports {self._overrides()} %")


def zero_line(axes: list[int]) -> str:
    """Makes the position of these machine axes the work zero."""
    return "G10L20P0" + "".join(f"{LETTERS[axis]}0" for axis in axes)


def override_bytes(feed: int | None, rapid: int | None) -> bytes:
    """The real-time bytes for overrides in percent: GRBL's are steps from 100."""
    data = b""
    if feed is not None:
        tens, ones = divmod(abs(feed - 100), 10)
        ten, one = (b"\x91", b"\x93") if feed > 100 else (b"\x92", b"\x94")
        data += b"\x90" + ten * tens + one * ones
    if rapid is not None:
        data += {100: b"\x95", 50: b"\x96", 25: b"\x97"}[rapid]
    return data
