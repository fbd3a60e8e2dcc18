"""A camera on USB (UVC), a network stream, or a film in its place, by OpenCV's VideoCapture."""

import os
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .camera_folder import Shot
from .driver import ActionFailed

if TYPE_CHECKING:
    from collections.abc import Iterator

    import cv2
    import numpy as np

STALE = 4  # pictures that a camera keeps from before it was asked
LIVE = Path("/dev")
SILENT = 0  # of OpenCV's levels of logging


class CameraVideo:
    """Takes pictures from `device`: a number, /dev/video2, an address (rtsp://...) or a film.

    A film gives one picture after the other; of a camera the newest is taken. `size` is asked of
    the camera, which may give another one.
    """

    def __init__(self, device: int | str, size: tuple[int, int] | None = None) -> None:
        self.device, self.size = device, size
        self._video: cv2.VideoCapture | None = None

    @property
    def name(self) -> str:
        """The camera as a sentence names it."""
        return f"/dev/video{self.device}" if isinstance(self.device, int) else self.device

    def open(self) -> None:
        """Take hold of the camera; raises OSError with a sentence."""
        import cv2

        self._check_there()
        with _quiet():
            video = cv2.VideoCapture(self.device)
            if not video.isOpened():
                video.release()
                raise OSError(f"{self.name} {self._why_shut()}")
            if self.size is not None and not self._is_film():
                video.set(cv2.CAP_PROP_FRAME_WIDTH, self.size[0])
                video.set(cv2.CAP_PROP_FRAME_HEIGHT, self.size[1])
        self._video = video

    def close(self) -> None:
        """Let go of the camera."""
        if self._video is not None:
            self._video.release()
            self._video = None

    def take(self) -> Shot:
        """The picture of now; raises ActionFailed. A camera that was plugged in again is taken again."""
        try:
            if self._video is None:
                self.open()
            picture = self._newest()
            if picture is None and not self._is_film():
                self.close()
                self.open()
                picture = self._newest()
        except OSError as fault:
            raise ActionFailed("CameraLost", str(fault)) from fault
        if picture is None:
            if self._is_film():
                raise ActionFailed("CameraLost", f"the film {self.name} has no more pictures")
            raise ActionFailed(
                "CameraLost",
                f"{self.name} is there but gives no picture: another program may be using it",
            )
        return Shot(picture)

    def _newest(self) -> "np.ndarray | None":
        assert self._video is not None
        with _quiet():
            if not self._is_film():
                for _ in range(STALE):
                    self._video.grab()
            taken, picture = self._video.read()
        return picture if taken else None

    def _is_film(self) -> bool:
        return isinstance(self.device, str) and Path(self.device).is_file()

    def _check_there(self) -> None:
        path = Path(self.name)
        if "://" in self.name or not LIVE.is_dir():
            return
        if not path.exists():
            others = ", ".join(sorted(map(str, LIVE.glob("video*"))))
            known = (
                f"there are {others}" if others else "there is no camera at all: is it plugged in?"
            )
            raise OSError(f"there is no camera {self.name}; {known}")
        if not os.access(path, os.R_OK):
            raise OSError(
                f"{self.name} may not be read by this user: join its group (often `video`)"
            )

    def _why_shut(self) -> str:
        if self._is_film():
            return "is no film that can be read"
        if "://" in self.name:
            return "does not answer"
        return "is there but cannot be opened: another program may be using it, or it is no camera"


@contextmanager
def _quiet() -> "Iterator[None]":
    """OpenCV's own lines about cameras: what matters of them is in our sentences."""
    import cv2

    # OpenCV 5 keeps these two in a module, OpenCV 4 beside the rest.
    log: Any = getattr(cv2.utils, "logging", cv2)
    level = log.getLogLevel()
    log.setLogLevel(SILENT)
    try:
        yield
    finally:
        log.setLogLevel(level)
