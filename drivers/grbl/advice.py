"""What a controller's settings should be for an instrument that must not lose its position, and why."""

from collections.abc import Iterator
from dataclasses import dataclass

from ..motion.bench import LETTERS
from .settings import Settings

FRAME_MM = (730.0, 810.0)
"""How far gantry@1 goes along x and y."""


@dataclass(frozen=True, slots=True)
class Advice:
    """A line that sets it, empty where a person has to find the value; and why."""

    line: str
    why: str


def advice(settings: Settings) -> Iterator[Advice]:
    """What to change, the most important first."""
    value = settings.values.get
    if not settings.homing:
        yield Advice("$22=1", "homing is off: without it the position is unknown after every start")
    if value(21, 0) == 0:
        yield Advice("$21=1", "hard limits are off: hitting a switch would not cut the motors")
    if value(20, 0) == 0:
        why = "soft limits are off: the controller's own net beneath the work area"
        if settings.firmware.off_both_ends:
            why += (
                ". With $21=1 they end a pull-off ($27) before both ends, so the work area does, too, and "
                "bench zero moves with it: set this before any place on the bench is written down"
            )
        yield Advice("$20=1", why)
    if value(1) not in (None, 255.0):
        yield Advice(
            "$1=255",
            f"the motors are let go {value(1, 0):g} ms after each move, and an axis may be pushed "
            f"or fall a step: 255 keeps them on",
        )
    if value(10) not in (None, 1.0, 3.0):
        yield Advice("$10=1", "reports give work positions: machine positions need no offset")
    if value(13) not in (None, 0.0):
        yield Advice("$13=0", "reports are in inches: millimetres have one digit more")
    for axis in range(min(settings.axes, 3)):
        letter = LETTERS[axis]
        if settings.steps_per_mm[axis] == 250.0 and settings.travel[axis] == 200.0:
            yield Advice(
                "",
                f"{letter} has the firmware's own defaults ($10{axis}=250, $13{axis}=200): measure a "
                f"move of 100 mm and set $10{axis}, and $13{axis} to the travel between the ends",
            )
    for axis, most in enumerate(FRAME_MM):
        if settings.travel[axis] - settings.pull_off > most:
            yield Advice(
                "",
                f"{LETTERS[axis]} travels {settings.travel[axis]:g} mm ($13{axis}), and gantry@1 goes to "
                f"{most:g} along {'xy'[axis]}: with gantry@2 all of it is used; or turn the bench with "
                f"`axes` if this is the other axis of your frame",
            )
