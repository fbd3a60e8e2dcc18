"""A controller's `$` settings, as far as a gantry needs them."""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, field

from ..motion.bench import LETTERS, Point
from .firmware import GRBL, Firmware

SCALE, TRAVEL = (13, *range(100, 106)), range(130, 136)
"""In what places are counted and told; how far each axis goes."""

AXIS_OR_PLACE = re.compile(r"^ *(?:([xyzabc]):|mpos_mm: (-?\d+(?:\.\d+)?))\s*$", re.MULTILINE)


def homes_at_of(configuration: str) -> dict[int, float]:
    """Where FluidNC's axes are after homing, from its configuration; one that does not home is left out."""
    places: dict[int, float] = {}
    axis = -1
    for letter, place in AXIS_OR_PLACE.findall(configuration):
        if letter:
            axis = LETTERS.index(letter.upper())
        else:
            places[axis] = float(place)
    return places


@dataclass(frozen=True, slots=True)
class Settings:
    """Read once after every boot. Lengths in mm, rates in mm/min, accelerations in mm/s2.

    Settings that a controller does not report are assumed to be GRBL's defaults. `options` are the
    letters of `[OPT:...]` in the answer to `$I`: the firmware's build options. `homes_at` is where each
    axis (0, 1, 2) is after homing, of a firmware with a scale of its own.
    """

    values: dict[int, float] = field(default_factory=dict)
    options: str = ""
    firmware: Firmware = GRBL
    homes_at: dict[int, float] | None = None

    @classmethod
    def read(cls, lines: list[str], options: str = "", firmware: Firmware = GRBL) -> "Settings":
        """From the lines of `$$` (`130=810.000`); values that are not numbers are left out."""
        values: dict[int, float] = {}
        for line in lines:
            number, _, value = line.partition("=")
            try:
                values[int(number)] = float(value)
            except ValueError:
                continue
        return cls(values, options, firmware)

    def changed(self, before: "Settings", numbers: Iterable[int]) -> str:
        """What another program has changed of these since, in words; empty if nothing."""
        old, new = before.values, self.values
        now = [n for n in numbers if old.get(n) != new.get(n)]
        return ", ".join(f"${n} from {old.get(n, 0):g} to {new.get(n, 0):g}" for n in now)

    @property
    def axes(self) -> int:
        """How many axes the machine has: at least three, at most six."""
        return next((n for n in range(3, 6) if 100 + n not in self.values), 6)

    def _each(self, first: int, default: float) -> Point:
        return tuple(self.values.get(first + axis, default) for axis in range(self.axes))

    @property
    def steps_per_mm(self) -> Point:
        return self._each(100, 250.0)

    @property
    def max_rate(self) -> Point:
        return self._each(110, 500.0)

    @property
    def acceleration(self) -> Point:
        return self._each(120, 10.0)

    @property
    def travel(self) -> Point:
        return self._each(130, 200.0)

    @property
    def unfit(self) -> str:
        """Why no move can end with these settings, and what to write; empty if nothing is wrong."""
        needs = (
            (100, self.steps_per_mm, "steps per mm"),
            (110, self.max_rate, "its fastest rate in mm/min"),
            (120, self.acceleration, "its acceleration in mm/s2"),
        )
        for first, values, what in needs:
            for axis, value in enumerate(values):
                if not 0 < value < math.inf:
                    return (
                        f"${first + axis} is {value:g}, so a move of {LETTERS[axis]} never ends: write "
                        f"{what}, `${first + axis}=...` (anything above 0 for an axis that is not there)"
                    )
        return ""

    @property
    def laser_mode(self) -> bool:
        """A spindle output is dark except in moves with a feed."""
        return self.values.get(32) == 1

    @property
    def homing(self) -> bool:
        return bool(int(self.values.get(22, 0)) & 1)

    @property
    def pull_off(self) -> float:
        return self.values.get(27, 1.0)

    @property
    def full_power(self) -> float:
        """What S is at full power of the spindle or laser."""
        return self.values.get(30, 1000.0)

    @property
    def tells_machine(self) -> bool:
        """Reports give machine positions; else they need the work offset."""
        return bool(int(self.values.get(10, 1)) & 1)

    @property
    def inches(self) -> bool:
        """Reports are in inches."""
        return bool(self.values.get(13, 0))

    @property
    def zero_where_homed(self) -> bool:
        """Homing makes its end the machine's zero (a build with HOMING_FORCE_SET_ORIGIN)."""
        return "Z" in self.options

    def homes_to_minus(self, axis: int) -> bool:
        """Where the limit switch of an axis (0, 1, 2) sits."""
        return bool(int(self.values.get(23, 0)) >> axis & 1)

    @property
    def ranges(self) -> tuple[tuple[float, float], ...]:
        """From the minus end to the plus end of each axis, less the pull-off at the switch's end.

        GRBL's machine space is negative (0 is at the plus end, -travel at the minus end), whichever
        way it homes; only firmware built that way has its 0 where it homes. FluidNC's goes on from
        its place after homing; an axis that does not home is at -travel to 0.
        """
        return tuple(self._range(axis) for axis in range(self.axes))

    def _range(self, axis: int) -> tuple[float, float]:
        travel, off = self.travel[axis], self.pull_off
        if self.homes_at is not None:
            at = self.homes_at.get(axis, 0.0)
            minus = axis in self.homes_at and self.homes_to_minus(axis)
            return (at, at + travel) if minus else (at - travel, at)
        if self.zero_where_homed:
            return (0.0, travel - off) if self.homes_to_minus(axis) else (off - travel, 0.0)
        if self.soft_off_both_ends:
            step = 1 / self.steps_per_mm[axis]  # where it stands is whole steps: none is outside
            return (off - travel + step, -off - step)
        return (-travel + off, 0.0) if self.homes_to_minus(axis) else (-travel, -off)

    @property
    def soft_off_both_ends(self) -> bool:
        """Soft limits that raise an alarm within the travel, at the end without a switch, too."""
        on = bool(self.values.get(20)) and bool(self.values.get(21))
        return self.firmware.off_both_ends and on

    @property
    def tolerance(self) -> float:
        """How far it may be from its target: 0.005 mm, or half a step if that is more.

        Plus the rounding of a report and of its offset: 0.0005 mm each, or 0.00005 inch.
        """
        return max(0.005, 0.5 / min(self.steps_per_mm) + (0.003 if self.inches else 0.001))

    @property
    def braking_s(self) -> float:
        """The longest time that stopping takes."""
        pairs = zip(self.max_rate, self.acceleration, strict=True)
        return max(rate / 60 / max(acceleration, 1.0) for rate, acceleration in pairs)
