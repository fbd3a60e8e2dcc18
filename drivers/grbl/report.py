"""Read GRBL's status report, which is sent only in part each time."""

import re
from dataclasses import dataclass

from ..motion.bench import Point

NUMBER = re.compile(r"-?\d+\.\d+")
MM_PER_INCH = 25.4


@dataclass(frozen=True, slots=True)
class Report:
    """One report: `state` as GRBL calls it (`Hold:0` is state Hold, part 0), lengths in mm.

    `machine` and `work` are None until the offset between them has been reported.
    """

    state: str
    part: int | None
    machine: Point | None
    work: Point | None
    feed_mm_per_min: float
    pins: str = ""

    @property
    def still(self) -> bool:
        """True if nothing moves according to this report. A line that was sent may still have to begin."""
        return self.state in ("Idle", "Alarm", "Sleep", "Check") or (
            self.state in ("Hold", "Door") and self.part == 0
        )

    @property
    def braking(self) -> bool:
        """True while it comes to a hold."""
        return (self.state, self.part) in (("Hold", 1), ("Door", 2))


class ReportReader:
    """Remembers work offset and overrides, which only every tenth to thirtieth report contains.

    `inches` if the controller reports in inches ($13=1).
    """

    def __init__(self) -> None:
        self.inches = False
        self.offset: Point | None = None
        self.overrides: tuple[int, ...] = ()

    def read(self, text: str) -> Report | None:
        """The report, or None if noise has damaged it."""
        state, _, rest = text.strip("<>").partition("|")
        parts = (field.partition(":") for field in rest.split("|"))
        fields = {name: value for name, _, value in parts}
        try:
            if "WCO" in fields:
                self.offset = self._point(fields["WCO"])
            if "Ov" in fields:
                self.overrides = tuple(map(int, fields["Ov"].split(",")))
            machine, work = self._places(fields)
            speeds = fields.get("FS") or fields.get("F") or "0"
            feed = float(speeds.split(",")[0]) * (MM_PER_INCH if self.inches else 1)
        except ValueError:
            return None
        name, _, part = state.partition(":")
        pins = fields.get("Pn", "")
        return Report(name, int(part) if part else None, machine, work, feed, pins)

    def contact(self, told: list[str]) -> Point | None:
        """Where the probe touched, from the text of `[PRB:...]`; None if it did not."""
        for text in reversed(told):
            place, _, touched = text.rpartition(":")
            if place.count(",") >= 2:
                return self._point(place) if touched == "1" else None
        return None

    def _places(self, fields: dict[str, str]) -> tuple[Point | None, Point | None]:
        if "MPos" in fields:
            machine = self._point(fields["MPos"])
            return machine, None if self.offset is None else _minus(machine, self.offset)
        work = self._point(fields.get("WPos", ""))
        return None if self.offset is None else _plus(work, self.offset), work

    def _point(self, text: str) -> Point:
        numbers = text.split(",")
        if len(numbers) < 3 or not all(NUMBER.fullmatch(number) for number in numbers):
            raise ValueError(f"{text!r} is not a position")
        scale = MM_PER_INCH if self.inches else 1.0
        return tuple(float(number) * scale for number in numbers)


def _minus(a: Point, b: Point) -> Point:
    return tuple(p - q for p, q in zip(a, b, strict=False))


def _plus(a: Point, b: Point) -> Point:
    return tuple(p + q for p, q in zip(a, b, strict=False))
