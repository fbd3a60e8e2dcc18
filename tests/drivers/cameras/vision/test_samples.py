"""Samples on a bench that the test paints itself: by their colours or their height, not their shade."""

import functools

import numpy as np
import pytest
from scenes import Chessboard, Lens, photograph, stand

from labrun.drivers.cameras.vision.board import Board
from labrun.drivers.cameras.vision.intrinsics import Intrinsics
from labrun.drivers.cameras.vision.measure import calibrate, outlines
from labrun.drivers.cameras.vision.view import DepthView

pytestmark = pytest.mark.slow

LENS = Lens(960, 540, 798.0, (479.5, 269.5))
EYE = Intrinsics(LENS.width, LENS.height, LENS.matrix(), np.array(LENS.distortion))
TRUTH, BOARD = Chessboard(), Board(9, 6, 25, 100, 300)
PLACE = stand(np.array([200.0, 270, 0]), 650, 33)
SLAB = (60.0, 150.0, 90.0, 50.0)  # left, front, width, length, mm


@functools.cache
def taken():
    """The bare bench and its board, without noise: grey, and depth in mm."""
    return photograph(LENS, PLACE, TRUTH)


class Bench:
    """A photograph to paint on: grey board, grainy grey bench, depth of the bench."""

    def __init__(self, seed=1):
        self.random = np.random.default_rng(seed)
        grey, depth = taken()
        rays = LENS.rays(np.stack(np.meshgrid(np.arange(960.0), np.arange(540.0)), -1)) @ PLACE.turn
        far = -PLACE.place[2] / rays[..., 2]
        self.x, self.y = (PLACE.place[k] + rays[..., k] * far for k in (0, 1))
        self.rays, self.depth = rays, depth
        grain = 1 + 0.12 * self.random.standard_normal(grey.shape)
        self.picture = np.repeat((grey * grain)[..., None], 3, axis=-1)

    def within(self, left, front, width, length):
        inside = (self.x > left) & (self.x < left + width)
        return inside & (self.y > front) & (self.y < front + length)

    def slab(self, colours, area=SLAB):
        """A flat thing of grains: each cell of 2 mm has one of these colours."""
        mask = self.within(*area)
        kinds = self.random.integers(0, len(colours), (400, 400))
        kind = kinds[(self.y // 2).astype(int) % 400, (self.x // 2).astype(int) % 400]
        self.picture[mask] = np.array(colours, float)[kind][mask]

    def shadow(self, area, left=0.45):
        self.picture[self.within(*area)] *= left

    def stone(self, area, height):
        """A grey box: its top as deep as it is high; its sides are not drawn."""
        far = (height - PLACE.place[2]) / self.rays[..., 2]
        x, y = (PLACE.place[k] + self.rays[..., k] * far for k in (0, 1))
        left, front, width, length = area
        top = (x > left) & (x < left + width) & (y > front) & (y < front + length)
        self.depth = np.where(top, far, self.depth)

    def found(self, **how):
        noisy = self.picture + self.random.normal(0, 2, self.picture.shape)
        depth = self.depth * self.random.normal(1, 0.0005, self.depth.shape)
        view = DepthView(np.clip(noisy, 0, 255).astype(np.uint8), depth, EYE)
        wanted = {"min_height_mm": 3.0, "min_area_mm2": 100.0, "flat": True, **how}
        return outlines(view, calibrate(view, BOARD), **wanted)


ROCK = [(200, 215, 190), (205, 205, 208), (158, 176, 222), (150, 178, 186)]


def box(sample):
    return sample["left"], sample["front"], sample["right"], sample["back"]


def test_a_bare_bench_with_a_board_and_a_shadow_holds_no_sample():
    bench = Bench()
    bench.shadow((20, 120, 200, 100))
    bench.shadow((360, 150, 60, 200))

    assert bench.found() == []


def test_a_flat_slab_is_found_with_its_outline_middle_and_area():
    bench = Bench()
    bench.slab(ROCK)
    (sample,) = bench.found()

    assert box(sample) == pytest.approx((60, 150, 150, 200), abs=2)
    assert (sample["x"], sample["y"], sample["height"]) == pytest.approx((105, 175, 0), abs=1)
    assert sample["area"] == pytest.approx(4500, rel=0.05)
    assert len(sample["outline"]) >= 4


def test_a_shadow_over_half_of_it_changes_little():
    bench = Bench()
    bench.slab(ROCK)
    bench.shadow((100, 120, 160, 110))
    (sample,) = bench.found()

    assert box(sample) == pytest.approx((60, 150, 150, 200), abs=3)
    assert sample["area"] == pytest.approx(4500, rel=0.07)


@pytest.mark.parametrize("colour", [(230, 232, 231), (8, 9, 8), (60, 60, 160)])
def test_a_white_a_black_and_a_red_slab_are_found(colour):
    bench = Bench()
    bench.slab([colour])
    (sample,) = bench.found()

    assert sample["area"] == pytest.approx(4500, rel=0.06)


def test_a_stone_of_the_bench_s_own_grey_is_found_by_its_height():
    bench = Bench()
    bench.stone((300, 150, 50, 40), 20)
    (sample,) = bench.found()

    assert (sample["x"], sample["y"], sample["height"]) == pytest.approx((325, 170, 20), abs=2)
    assert sample["area"] == pytest.approx(2000, rel=0.15)


@pytest.mark.soak
def test_the_largest_comes_first_and_the_small_are_left_out():
    bench = Bench()
    bench.slab(ROCK)
    bench.slab(ROCK, (250, 160, 20, 20))
    bench.stone((300, 220, 45, 45), 15)

    assert [round(s["height"]) for s in bench.found()] == [0, 15, 0]
    assert len(bench.found(min_area_mm2=1000)) == 2
    assert [round(s["height"]) for s in bench.found(flat=False)] == [15]


def test_a_board_that_was_taken_away_hides_nothing():
    bench = Bench()
    view_with_board = bench.found()
    bench.picture[bench.within(50, 250, 300, 230)] = 120
    noisy = np.clip(bench.picture + bench.random.normal(0, 2, bench.picture.shape), 0, 255)
    before = Bench()
    fit = calibrate(
        DepthView(before.picture.clip(0, 255).astype(np.uint8), before.depth, EYE), BOARD
    )
    bench.picture = noisy
    bench.slab(ROCK, (150, 320, 80, 60))
    view = DepthView(bench.picture.clip(0, 255).astype(np.uint8), bench.depth, EYE)
    (sample,) = outlines(view, fit, 3.0, 100.0, True)

    assert view_with_board == []
    assert (sample["x"], sample["y"]) == pytest.approx((190, 350), abs=2)
