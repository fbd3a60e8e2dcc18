"""Depth around a pixel: the median of what is known, and how it spreads."""

import numpy as np
import pytest

from labrun.drivers.cameras.vision.depth import depth_around
from labrun.drivers.cameras.vision.intrinsics import Intrinsics
from labrun.drivers.cameras.vision.view import DepthView, View
from labrun.drivers.driver import ActionFailed

EYE = Intrinsics.ideal(80, 60, 100)
PICTURE = np.zeros((60, 80, 3), np.uint8)


def slanted():
    v, u = np.mgrid[:60, :80]
    return (500 + 2.0 * u - 1.0 * v).astype(np.float32)


def test_holes_and_pixels_that_are_far_off_do_not_matter():
    depth = slanted()
    depth[28:31, 38:43] = np.nan
    depth[33, 41] = 9000
    middle, spread = depth_around(depth, 40.2, 29.7)

    assert middle == pytest.approx(500 + 80 - 30, abs=3)
    assert spread < 3


def test_the_spread_is_that_of_one_pixel_not_of_the_slope():
    random = np.random.default_rng(2)
    noisy = slanted() + random.normal(0, 4, (60, 80)).astype(np.float32)

    assert depth_around(noisy, 40, 30)[1] == pytest.approx(4, rel=0.3)
    assert depth_around(slanted(), 40, 30)[1] < 1e-3


@pytest.mark.parametrize(("u", "v"), [(1, 30), (78, 2), (40, 59), (0, 0)])
def test_at_the_picture_s_edge_a_slope_does_not_shift_the_median(u, v):
    assert depth_around(slanted(), u, v)[0] == pytest.approx(500 + 2 * u - v, abs=1e-3)


@pytest.mark.parametrize("hole", [np.s_[:, 41:], np.s_[31:, :], np.s_[29:33, :43]])
def test_a_hole_on_one_side_does_not_shift_the_depth_along_the_slope(hole):
    depth = slanted()
    depth[hole] = np.nan

    assert depth_around(depth, 40, 30)[0] == pytest.approx(500 + 80 - 30, abs=1)


def test_where_nothing_is_known_it_is_said():
    depth = slanted()
    depth[20:45, 30:55] = np.nan
    with pytest.raises(
        ActionFailed, match="NoDepth: only 0% of the depth around pixel 42, 32 is known"
    ):
        depth_around(depth, 42, 32)


def test_a_depth_map_of_another_size_than_the_picture_is_refused():
    with pytest.raises(
        ActionFailed, match="NoDepth: the depth map is 40 x 30, and the picture is 80 x 60"
    ):
        DepthView(PICTURE, np.ones((30, 40)), EYE)


@pytest.mark.parametrize("value", [np.nan, 0.0, -1.0, np.inf])
def test_a_depth_map_that_knows_nothing_is_refused(value):
    with pytest.raises(ActionFailed, match="contains no depth"):
        _ = DepthView(PICTURE, np.full((60, 80), value), EYE).depth


def test_a_picture_without_depth_asks_for_the_height():
    with pytest.raises(ActionFailed, match="NoDepth: this camera sees no depth: give the height"):
        _ = View(PICTURE, EYE).depth


def test_a_picture_of_another_size_than_the_lens_is_refused():
    with pytest.raises(
        ActionFailed, match="the picture is 80 x 60, and the lens is known for pictures of 90"
    ):
        View(PICTURE, Intrinsics.ideal(90, 60, 100))
