"""A USB camera (UVC), a network stream, or a video file in its place, through OpenCV's VideoCapture."""

import os
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..driver import ActionFailed
from .folder import Shot

if TYPE_CHECKING:
    from collections.abc import Iterator

    import cv2
    import numpy as np

STALE = 4  # old pictures that a camera keeps in its buffer
LIVE = Path("/dev")
SILENT = 0  # OpenCV's log level


class CameraVideo:
    """Takes pictures from `device`: a number, /dev/video2, an address (rtsp://...) or a video file.

    A video file gives one picture after the other; a camera gives its newest. `size` is requested
    from the camera, which may choose another one.
    """

    def __init__(self, device: int | str, size: tuple[int, int] | None = None) -> None:
        self.device, self.size = device, size
        self._video: cv2.VideoCapture | None = None

    @property
    def name(self) -> str:
        """The camera's name in messages."""
        return f"/dev/video{self.device}" if isinstance(self.device, int) else self.device

    def open(self) -> None:
        """Open the camera; raises OSError with the reason."""
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
        """Release the camera."""
        if self._video is not None:
            self._video.release()
            self._video = None

    def take(self) -> Shot:
        """The current picture; raises ActionFailed. A camera that was plugged in again is reopened."""
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
                raise ActionFailed("CameraLost", f"the video file {self.name} has no more pictures")
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
            raise OSError(f"this user may not read {self.name}: join its group (often `video`)")

    def _why_shut(self) -> str:
        if self._is_film():
            return "is not a readable video file"
        if "://" in self.name:
            return "does not respond"
        return (
            "is there but cannot be opened: another program may be using it, or it is not a camera"
        )


@contextmanager
def _quiet() -> "Iterator[None]":
    """Silence OpenCV's own lines about cameras: our messages contain what matters of them."""
    import cv2

    # OpenCV 5 keeps these two in a module, OpenCV 4 beside the rest.
    log: Any = getattr(cv2.utils, "logging", cv2)
    level = log.getLogLevel()
    log.setLogLevel(SILENT)
    try:
        yield
    finally:
        log.setLogLevel(level)
