"""Places of things by a photograph, held against a projection that knows nothing of labrun.

The figures of `benchmarks/vision.py` at a tenth of its size, and every way to be refused.
"""

from dataclasses import replace

import cv2
import numpy as np
import pytest
import vision
from scenes import Chessboard, Lens, photograph, stand

from labrun.drivers.cameras.vision import measure
from labrun.drivers.cameras.vision.board import Board
from labrun.drivers.cameras.vision.intrinsics import Intrinsics
from labrun.drivers.cameras.vision.view import DepthView, View
from labrun.drivers.driver import ActionFailed

LENS = Lens(640, 360, 532.5, (322.0, 176.0), (-0.05, 0.02, 0.0005, 0.0004, 0.0))
EYE = Intrinsics(LENS.width, LENS.height, LENS.matrix(), np.array(LENS.distortion))
TRUTH, BOARD = Chessboard(), Board(9, 6, 25, 100, 300)
PLACE = stand(TRUTH.middle() - (0, 40, 0), 560, 32, 6, 3)


@pytest.fixture(scope="module")
def taken():
    grey, depth = photograph(LENS, PLACE, TRUTH, np.random.default_rng(1))
    return np.repeat(grey[..., None], 3, axis=-1), depth


def failed(work) -> ActionFailed:
    with pytest.raises(ActionFailed) as found:
        work()
    return found.value


@pytest.mark.soak
def test_95_of_100_places_are_within_the_figures():
    random = np.random.default_rng(5)
    rendered = [row for _ in range(1) for row in vision.scene(random, 30, True)]
    projected = [row for _ in range(60) for row in vision.scene(random, 10, False)]
    xy_by_depth, z_by_depth, xy_by_height, *told = np.array(rendered + projected, float).T

    assert np.percentile(xy_by_depth, 95) < 1.0
    assert np.percentile(z_by_depth, 95) < 2.0
    assert np.percentile(xy_by_height, 95) < 0.9
    assert min(share.mean() for share in told) > 0.95  # within the uncertainty that is told


def test_a_photograph_places_the_camera_and_a_thing_by_depth_and_by_height(taken):
    picture, depth = taken
    view = DepthView(picture, depth * np.random.default_rng(3).normal(1, 0.005, depth.shape), EYE)
    fit = measure.calibrate(view, BOARD)
    u, v = LENS.pixels(PLACE.seen(np.array([180.0, 260.0, 0.0])))
    by_depth = measure.locate(view, fit, u, v, None)
    by_height = measure.locate(view, fit, u, v, 0.0)

    assert fit.pose.place_mm == pytest.approx(PLACE.place, abs=1)
    assert (by_depth["x"], by_depth["y"]) == pytest.approx((180, 260), abs=0.7)
    assert by_depth["z"] == pytest.approx(0, abs=1.5)
    assert (by_height["x"], by_height["y"], by_height["z"]) == pytest.approx((180, 260, 0), abs=0.4)
    assert 0.3 < by_height["uncertainty"] < by_depth["uncertainty"] < 8


def test_a_picture_from_above_has_each_corner_of_the_board_where_it_lies(taken):
    fit = measure.calibrate(View(taken[0], EYE), BOARD)
    data, told = measure.above_file(View(taken[0], EYE), fit, "above.png")
    cells = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    cell_mm = (told["right"] - told["left"]) / told["width"]
    grey, seen = cells[..., :3].mean(axis=-1), cells[..., 3]
    x, y = BOARD.corners_mm().reshape(-1, 3)[:, :2].T
    columns, rows = (x - told["left"]) / cell_mm, (told["back"] - y) / cell_mm
    off = 6 / cell_mm  # into the squares around a corner: two of them are black, two white
    around = [
        grey[np.int_(rows + v), np.int_(columns + u)] for u in (-off, off) for v in (-off, off)
    ]
    light = np.array(around) > 128

    assert cells.shape == (told["height"], told["width"], 4)
    assert (light[0] == light[3]).all() and (light[1] == light[2]).all()
    assert (light[0] != light[1]).all()
    assert {0, 255} == set(np.unique(seen).tolist())
    away = replace(fit, pose=replace(fit.pose, turn=-fit.pose.turn))
    past = failed(lambda: measure.above_file(View(taken[0], EYE), away, "a.jpg"))

    assert past.name == "OutsidePicture"


def test_a_depth_that_contradicts_the_board_s_squares_is_found_out(taken):
    picture, depth = taken
    in_metres = failed(lambda: measure.calibrate(DepthView(picture, depth / 1000, EYE), BOARD))
    squares = Board(9, 6, 30, 100, 300)
    larger = failed(lambda: measure.calibrate(DepthView(picture, depth, EYE), squares))

    assert in_metres.name == larger.name == "PoorFit"
    assert "are the square size and the depth unit right?" in larger.message


def test_pixels_outside_and_lines_of_sight_past_the_bench_are_refused(taken):
    view = View(taken[0], EYE)
    fit = measure.calibrate(view, BOARD)
    outside = failed(lambda: measure.locate(view, fit, 640, 10, 0.0))
    above = failed(lambda: measure.locate(view, fit, 320, 10, 2000.0))

    assert outside.name == above.name == "OutsidePicture"
    assert "pixel 640, 10 is not in a picture of 640 x 360" in outside.message
    assert "looks past the bench: nothing 2000 mm high lies there" in above.message


def test_an_all_nan_depth_still_gives_the_camera_s_place_but_no_thing_s(taken):
    view = DepthView(taken[0], np.full(taken[1].shape, np.nan), EYE)
    fit = measure.calibrate(view, BOARD)
    failure = failed(lambda: measure.locate(view, fit, 320, 180, None))

    assert failure.name == "NoDepth"
    assert measure.locate(view, fit, 320, 180, 3.0)["z"] == pytest.approx(3)
