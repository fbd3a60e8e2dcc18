"""A camera that stays where it is: a source of pictures, and its position, which outlives its server."""

import json
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, Protocol

from ...system.files import write_whole
from ..driver import ActionFailed, GoalContext, Place, check_keys
from .depth_camera import DepthCamera
from .folder import Shot
from .vision.board import RUNS

if TYPE_CHECKING:
    from .vision.pose import Calibration
    from .vision.view import View

KEPT = "calibration.json"
ANSWER_S = 5.0
"""How long a picture of a camera with a library of its own may take."""
MUCH = 1e6


class Source(Protocol):
    """Where pictures come from: a folder, a video, a camera with a library of its own."""

    def open(self) -> None:
        """Raise OSError, with the reason, if it cannot be used."""

    def close(self) -> None:
        """Release it."""

    def take(self) -> Shot:
        """What it sees now; raises ActionFailed."""
        ...


class LibrarySource(ABC):
    """A camera whose own library runs a pipeline, and raises RuntimeError."""

    _pipeline: Any = None

    @property
    @abstractmethod
    def name(self) -> str:
        """What gives the pictures, in messages."""

    @abstractmethod
    def open(self) -> None:
        """Start it; raises OSError with the reason."""

    @abstractmethod
    def _read(self) -> Shot:
        """The next picture of the running pipeline; raises RuntimeError."""

    def close(self) -> None:
        """Release it."""
        pipeline, self._pipeline = self._pipeline, None
        if pipeline is not None:
            pipeline.stop()

    def take(self) -> Shot:
        """The current picture; raises ActionFailed. A camera that was plugged in again is started again."""
        try:
            if self._pipeline is None:
                self.open()
            try:
                return self._read()
            except RuntimeError:
                self.close()
                self.open()
                return self._read()
        except OSError as fault:
            raise ActionFailed("CameraLost", str(fault)) from fault
        except RuntimeError as fault:
            raise ActionFailed("CameraLost", f"{self.name} gives no picture: {fault}") from fault


class StillCamera(DepthCamera):
    """Keeps its position in a file. A move is not detected: recalibrate after any move."""

    def __init__(self, place: Place, source: Source, options: tuple[str, ...]) -> None:
        super().__init__(place)
        check_keys((*options, "x_runs"), place.config)
        self.source = source
        self.x_runs = str(place.config.get("x_runs", "right"))
        if self.x_runs not in RUNS:
            raise ValueError(f"x_runs is {self.x_runs!r}; it must be one of: {', '.join(RUNS)}")
        self.connected = False

    @property
    @abstractmethod
    def lens(self) -> str:
        """The lens for which a position holds, by name."""

    def view(self, shot: Shot) -> "View":
        """A shot as something that can be measured in; of a camera that knows its lens and sees depth.

        Raises ActionFailed.
        """
        from .vision.view import DepthView

        assert shot.depth is not None and shot.eye is not None
        return DepthView(shot.picture, shot.depth, shot.eye, self.x_runs, shot.reach_mm)

    async def open(self) -> None:
        await self.worked(self.source.open)
        self.connected = True
        self.calibration = self._kept()

    async def close(self) -> None:
        self.connected = False
        await self.worked(self.source.close)

    async def status(self) -> dict[str, Any]:
        rms = 0.0 if self.calibration is None else round(self.calibration.rms_px, 3)
        calibrated = self.calibration is not None
        return {"connected": self.connected, "calibrated": calibrated, "rms": rms}

    async def look(self, action: str, goal: GoalContext) -> "View":
        try:
            shot = await self.worked(self.source.take)
        except ActionFailed:
            self.connected = False
            raise
        self.connected = True
        return await self.worked(self.view, shot)

    def keep(self, fit: "Calibration", goal: GoalContext) -> None:
        text = json.dumps({"camera": self.lens, "calibration": fit.to_dict(), "goal": goal.id})
        write_whole(self.place.folder / KEPT, text.encode())

    def _kept(self) -> "Calibration | None":
        """The stored position, unless it was for another lens or cannot be read."""
        from .vision.pose import Calibration

        try:
            kept = json.loads((self.place.folder / KEPT).read_text(encoding="utf-8"))
            self.calibrated_by = kept.get("goal")
            known = kept["camera"] == self.lens
            return Calibration.from_dict(kept["calibration"]) if known else None
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            self.calibrated_by = None
            return None


def picture_size(config: dict[str, Any]) -> tuple[int, int] | None:
    """`size: [width, height]`, where it is given; raises ValueError."""
    size = config.get("size")
    if size is None:
        return None
    if not (isinstance(size, list) and len(size) == 2 and all(type(one) is int for one in size)):
        raise ValueError(f"size is {size!r}; write [width, height] in pixels")
    return size[0], size[1]


def above_zero(value: Any, name: str) -> float:
    """A number of the configuration; raises ValueError."""
    number = float(value)
    if not 0 < number < MUCH:
        raise ValueError(f"{name} is {value!r}; it must be a number above 0")
    return number
