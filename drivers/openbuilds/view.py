"""What OpenBuilds CONTROL tells ten times a second, as far as a gantry needs it."""

from dataclasses import dataclass
from typing import Any

Point = tuple[float, float, float]

NONE, OPENING, CONNECTED, PLAYING, PAUSED, ALARM, FLASHING = range(7)
"""Its `connectionStatus`. 5 is the one sure sign of an error or alarm; texts may stay empty."""


@dataclass(frozen=True, slots=True)
class View:
    """One `status` event: `run` is GRBL's state or CONTROL's own word (Running, Stopped, ...).

    `run` may say Idle while the axes move, and it freezes when the controller falls silent.
    """

    connection: int
    run: str
    work: Point
    offset: Point
    active_port: str
    alarm: str
    options: str  # the letters of how the firmware was built

    @property
    def machine(self) -> Point:
        """CONTROL tells no machine position: it is the sum of these two."""
        x, y, z = (w + o for w, o in zip(self.work, self.offset, strict=True))
        return x, y, z

    @property
    def held(self) -> bool:
        """Whether a feed hold has come to its end, or CONTROL says that it is paused."""
        return self.run in ("Hold", "Hold:0", "Paused")


def read_view(status: Any) -> View | None:
    """From the event's payload; None where it has another shape."""
    try:
        comms, position = status["comms"], status["machine"]["position"]
        return View(
            int(comms["connectionStatus"]),
            str(comms["runStatus"]),
            _point(position["work"]),
            _point(position["offset"]),
            str((comms.get("interfaces") or {}).get("activePort") or ""),
            str(comms.get("alarm") or ""),
            "".join(map(str, (status["machine"].get("firmware") or {}).get("features") or ())),
        )
    except (KeyError, TypeError, ValueError):
        return None


def _point(written: dict[str, Any]) -> Point:
    x, y, z = (float(written[axis]) for axis in "xyz")
    return x, y, z
