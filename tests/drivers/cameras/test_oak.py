"""An OAK camera as far as it goes without one: frames of its library, through a pipeline on this machine.

What the camera itself does (its eyes, its match, its straightening) is not here; what is made of the
frames that it sends, and what is said where it is missing or goes, is.
"""

import time
from datetime import timedelta

import numpy as np
import pytest
from scenes import Chessboard, Lens, photograph, stand

from labrun.drivers.cameras.oak import DEPTH, PICTURE, Oak, OakDevice
from labrun.drivers.driver import ActionFailed, GoalContext, Place

from ..played import played

dai = pytest.importorskip("depthai", reason="needs depthai: labrun[oak]")

LENS = Lens(640, 360, 532.5, (322.0, 176.0))
BOARD = Chessboard()
PLACE = stand(BOARD.middle(), 520, 30, 4)
REACH_MM = 450.0 * 75


class Frames(dai.node.ThreadedHostNode):
    """Sends a picture and its depth, again and again."""

    def __init__(self) -> None:
        dai.node.ThreadedHostNode.__init__(self)
        self.picture, self.depth = self.createOutput(), self.createOutput()
        grey, far = photograph(LENS, PLACE, BOARD, np.random.default_rng(1))
        self.seen = np.repeat(grey[..., None], 3, axis=-1), np.round(far).astype(np.uint16)

    def run(self) -> None:
        kinds = dai.ImgFrame.Type.BGR888i, dai.ImgFrame.Type.RAW16
        at = dai.ImgTransformation(LENS.width, LENS.height, LENS.matrix().tolist())
        number = 0
        while self.isRunning():
            number += 1
            for out, seen, kind in zip((self.picture, self.depth), self.seen, kinds, strict=True):
                frame = dai.ImgFrame()
                frame.setType(kind)
                frame.setSize(LENS.width, LENS.height)
                frame.setData(seen.view(np.uint8).ravel())
                frame.setTimestamp(timedelta(milliseconds=33 * number))
                frame.setTransformation(at)
                out.send(frame)
            time.sleep(0.01)


class OnThisMachine(OakDevice):
    kept = []  # noqa: RUF012 - to free a pipeline waits for its threads, and they for this one

    def begin(self):
        pipeline = dai.Pipeline(False)
        source, pairs = pipeline.create(Frames), pipeline.create(dai.node.Sync)
        pairs.setRunOnHost(True)
        source.picture.link(pairs.inputs[PICTURE])
        source.depth.link(pairs.inputs[DEPTH])
        queue = pairs.out.createOutputQueue(maxSize=1, blocking=False)
        self.reach_mm, self.id = REACH_MM, "14442C10"
        pipeline.start()
        self.kept.append(pipeline)
        return pipeline, queue


def camera(folder, **config):
    (folder / "own").mkdir(exist_ok=True)
    driver = Oak(Place("overview", config, {}, folder / "own", folder))
    driver.source = driver.device = OnThisMachine(None, (640, 360), 60)
    return driver


@pytest.mark.slow
def test_its_frames_find_a_place_on_the_bench_also_after_it_was_gone(tmp_path):
    async def story(driver):
        fit = await driver.calibrate(GoalContext("1"), x=BOARD.x, y=BOARD.y)
        driver.device._pipeline.stop()
        u, v = LENS.pixels(PLACE.seen(np.array([200, 260, 0.0])))
        return fit, await driver.locate_point(GoalContext("2"), u=float(u), v=float(v)), driver.lens

    fit, deep, lens = played(camera(tmp_path), story)

    assert fit["rms"] < 0.3
    assert [fit[axis] for axis in "xyz"] == pytest.approx(PLACE.place, abs=1)
    away = np.linalg.norm([deep["x"] - 200, deep["y"] - 260, deep["z"]])
    assert away < min(2.0, deep["uncertainty"])
    assert lens == "OAK 14442C10"


def test_a_camera_that_is_not_there_is_said(tmp_path):
    (tmp_path / "own").mkdir()
    driver = Oak(Place("overview", {}, {}, tmp_path / "own", tmp_path))

    with pytest.raises(OSError, match="there is no OAK camera: is it plugged in"):
        driver.device.open()
    with pytest.raises(ActionFailed, match="there is no OAK camera"):
        driver.device.take()


def test_a_configuration_that_cannot_be_is_refused(tmp_path):
    with pytest.raises(ValueError, match="config has no key camera; its keys are: device, size"):
        Oak(Place("overview", {"camera": "cam.yaml"}, {}, tmp_path, tmp_path))
