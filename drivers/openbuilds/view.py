"""What OpenBuilds CONTROL reports ten times a second, as far as a gantry needs it."""

from dataclasses import dataclass
from typing import Any

from ..motion.bench import Point

NONE, OPENING, CONNECTED, PLAYING, PAUSED, ALARM = range(6)
"""Its `connectionStatus`. 5 is the only reliable sign of an error or alarm; texts may stay empty."""


OVERRIDES = ("feedOverride", "rapidOverride")


@dataclass(frozen=True, slots=True)
class View:
    """One `status` event: `run` is GRBL's state or CONTROL's own (Running, Stopped, ...).

    `run` may be Idle while the axes move, and it freezes when the controller falls silent.
    """

    connection: int
    run: str
    work: Point
    offset: Point
    active_port: str
    alarm: str
    options: str  # the letters of the firmware's build options
    firmware: str  # as CONTROL calls it: gnea, grblHAL, FluidNC
    pins: str
    overrides: tuple[int, ...]

    @property
    def machine(self) -> Point:
        """CONTROL reports no machine position: it is the sum of these two."""
        return tuple(w + o for w, o in zip(self.work, self.offset, strict=True))

    @property
    def held(self) -> bool:
        """Whether a feed hold is complete, or CONTROL reports that it is paused."""
        return self.run in ("Hold", "Hold:0", "Paused")

    @property
    def still(self) -> bool:
        """Whether it is reported neither as moving nor on its way to a hold."""
        return not self.run.startswith(("Run", "Jog", "Hold"))


def read_view(status: Any) -> View | None:
    """From the event's payload; None if it has another structure."""
    try:
        comms, position = status["comms"], status["machine"]["position"]
        machine, axes = status["machine"], "xyz"
        firmware = machine.get("firmware") or {}
        if machine.get("has4thAxis"):
            axes += "a"
        overrides = machine.get("overrides") or {}
        return View(
            int(comms["connectionStatus"]),
            str(comms["runStatus"]),
            _point(position["work"], axes),
            _point(position["offset"], axes),
            str((comms.get("interfaces") or {}).get("activePort") or ""),
            str(comms.get("alarm") or ""),
            "".join(map(str, firmware.get("features") or ())),
            str(firmware.get("platform") or ""),
            "".join(map(str, machine.get("inputs") or ())),
            tuple(int(overrides[name]) for name in OVERRIDES if name in overrides),
        )
    except (KeyError, TypeError, ValueError):
        return None


def _point(written: dict[str, Any], axes: str) -> Point:
    return tuple(float(written[axis]) for axis in axes)
