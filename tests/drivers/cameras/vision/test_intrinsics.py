"""Rays and pixels of a lens with distortion, beside a projection that knows nothing of OpenCV."""

import numpy as np
import pytest
from scenes import Lens

from labrun.drivers.cameras.vision.intrinsics import Intrinsics

STRAIGHT = Lens()
BENT = Lens(distortion=(-0.17, 0.05, 0.001, -0.0008, -0.004), middle=(655.2, 341.9))


def eye(lens: Lens) -> Intrinsics:
    return Intrinsics(lens.width, lens.height, lens.matrix(), np.array(lens.distortion))


@pytest.mark.parametrize("lens", [STRAIGHT, BENT])
def test_points_appear_where_the_truth_has_them(lens):
    random = np.random.default_rng(1)
    seen = random.uniform((-300, -150, 500), (300, 150, 900), (4, 5, 3))

    assert eye(lens).pixels(seen) == pytest.approx(lens.pixels(seen), abs=1e-6)


@pytest.mark.parametrize("lens", [STRAIGHT, BENT])
def test_rays_are_those_of_the_truth_into_the_corners_of_the_picture(lens):
    u, v = np.meshgrid(np.linspace(0, lens.width - 1, 9), np.linspace(0, lens.height - 1, 7))
    pixels = np.stack([u, v], -1)

    assert eye(lens).rays(pixels) == pytest.approx(lens.rays(pixels), abs=1e-8)
    assert eye(lens).pixels(eye(lens).rays(pixels)) == pytest.approx(pixels, abs=1e-5)


def test_a_picture_ends_with_its_last_pixel():
    lens = eye(STRAIGHT)

    assert lens.holds(0, 0) and lens.holds(1279, 719)
    assert not lens.holds(1279.1, 0) and not lens.holds(0, -0.1)
