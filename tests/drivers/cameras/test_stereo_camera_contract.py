"""The depth camera keeps depth_camera@1 on a real server, before a folder of photographs."""

import contextlib
import functools
import os
import threading
from contextlib import contextmanager
from pathlib import Path

import cv2
import numpy as np
import pytest
from scenes import Chessboard, Lens, photograph, stand

from labrun.drivers.cameras.still_camera import KEPT
from labrun.drivers.cameras.vision.camera import Camera
from labrun.drivers.cameras.vision.camera_file import write_camera
from labrun.drivers.cameras.vision.intrinsics import Intrinsics
from labrun.drivers.contract_tests import Case, KeepsContract

pytestmark = pytest.mark.posix("Windows has no named pipes")

LENS = Lens(640, 360, 532.5, (322.0, 176.0), (-0.05, 0.02, 0.0005, 0.0004, 0.0))
BOARD = Chessboard()
DEVELOPS_S = 2.5


@pytest.mark.slow
class TestStereoCamera(KeepsContract):
    case = Case(
        driver="stereo_camera",
        good={
            "capture": {"image": "pictures/a.png", "depth": "pictures/a_depth.png"},
            "calibrate": {"x": 100, "y": 300},
            "last_calibration": {},
            "locate_point": {"u": 320, "v": 180},
            "locate_samples": {},
        },
        needs={"locate_point": ["calibrate"], "locate_samples": ["calibrate"]},
        lasting="calibrate",
    )

    def happened(self, folder, goal_id):
        kept = (folder / "server").rglob(KEPT)
        return any(goal_id in path.read_text(encoding="utf-8") for path in kept)

    @contextmanager
    def peer(self, folder, *, slow):
        eye = Intrinsics(LENS.width, LENS.height, LENS.matrix(), np.array(LENS.distortion))
        write_camera(folder / "cam.yaml", Camera(eye))
        (folder / "photos").mkdir()
        picture, depth = files()
        (folder / "photos" / "a_depth.png").write_bytes(depth)
        config = {"camera": str(folder / "cam.yaml"), "folder": str(folder / "photos")}
        if slow:
            with developing(folder / "photos" / "a.png", picture):
                yield config
        else:
            (folder / "photos" / "a.png").write_bytes(picture)
            yield config


@functools.cache
def files() -> tuple[bytes, bytes]:
    """A photograph and its depth map, as PNG files."""
    grey, depth = photograph(
        LENS, stand(BOARD.middle(), 520, 30, 4), BOARD, np.random.default_rng(1)
    )
    made = np.repeat(grey[..., None], 3, axis=-1), np.round(depth * 10).astype(np.uint16)
    picture, tenths = (cv2.imencode(".png", one)[1].tobytes() for one in made)
    return picture, tenths


@contextmanager
def developing(path: Path, picture: bytes):
    """A picture that takes a while to be there, each time that it is read: a named pipe."""
    os.mkfifo(path)
    over = threading.Event()

    def develop():
        while not over.wait(0.02):
            with contextlib.suppress(OSError):  # ENXIO: nobody reads; EPIPE: the reader was killed
                pipe = os.open(path, os.O_WRONLY | os.O_NONBLOCK)
                over.wait(DEVELOPS_S)
                os.set_blocking(pipe, True)
                with os.fdopen(pipe, "wb") as end:
                    end.write(picture)

    thread = threading.Thread(target=develop)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join(10)
