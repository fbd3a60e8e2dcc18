"""A lens measured by photographs of a board: near its truth, or a sentence why not."""

import numpy as np
import pytest
from scenes import Chessboard, Lens, photograph, stand

from labrun.drivers.cameras.vision.board import Board, find_corners
from labrun.drivers.cameras.vision.lens import LensFault, fit_lens, fit_pair
from labrun.drivers.cameras.vision.rig import rectification
from labrun.drivers.cameras.vision.view import StereoView

# The suite tests `labrun calibrate-camera`.
pytestmark = pytest.mark.soak
LENS = Lens(640, 360, 532.5, (326.0, 174.0), (-0.08, 0.03, 0.001, -0.0007, 0.0))
RIGHT = Lens(640, 360, 535.0, (316.0, 182.0), (-0.07, 0.02, 0.0004, 0.0006, 0.0))
TRUTH, BOARD = Chessboard(), Board(9, 6, 25)
BASELINE = 60.0


def places(count, seed=1, tilt=(5, 45)):
    """Cameras that have the whole board in both eyes."""
    random, found = np.random.default_rng(seed), []
    while len(found) < count:
        middle = TRUTH.middle() + np.append(random.uniform(-70, 70, 2), 0)
        angles = random.uniform(*tilt), random.uniform(0, 360), random.uniform(-20, 20)
        place = stand(middle, random.uniform(330, 560), *angles)
        eyes = ((LENS, place), (RIGHT, place.beside(BASELINE)))
        seen = np.array([lens.pixels(eye.seen(TRUTH.corners())) for lens, eye in eyes])
        if seen.min() > 12 and (seen < (628, 348)).all():
            found.append(place)
    return found


@pytest.fixture(scope="module")
def pairs():
    random = np.random.default_rng(2)
    return {
        f"{n}.png": (
            photograph(LENS, place, TRUTH, random)[0],
            photograph(RIGHT, place.beside(BASELINE), TRUTH, random)[0],
        )
        for n, place in enumerate(places(9))
    }


@pytest.fixture(scope="module")
def greys(pairs):
    return {name: pair[0] for name, pair in pairs.items()}


def fault(pictures, board=BOARD) -> str:
    with pytest.raises(LensFault) as found:
        fit_lens(pictures, board)
    return str(found.value)


def test_the_lens_is_found_and_every_picture_s_error_is_told(greys):
    fit = fit_lens(greys, BOARD)
    eye = fit.camera.left

    assert fit.rms_px < 0.15 and set(fit.errors_px) == set(greys)
    assert max(fit.errors_px.values()) < 0.2 and fit.odd == ()
    assert eye.matrix[0, 0] == pytest.approx(LENS.focal, abs=4 * fit.focal_sd_px)
    assert fit.focal_sd_px < 6
    assert eye.matrix[:2, 2] == pytest.approx(LENS.middle, abs=6)
    seen = np.array([[-200.0, -90, 500], [180, 100, 500], [0, 0, 500]])
    ours, truth = eye.pixels(seen), LENS.pixels(seen)
    assert ours - ours[2] == pytest.approx(truth - truth[2], abs=1.5)
    assert fit.camera.board == BOARD and fit.covered > 0.5


def test_columns_and_rows_may_be_exchanged_as_a_lens_knows_no_bench(greys):
    assert fit_lens(greys, Board(6, 9, 25)).rms_px < 0.15


def test_pictures_that_do_not_show_the_board_are_named_and_left_out(greys):
    empty = np.full((360, 640), 120, np.uint8)
    told = []
    fit = fit_lens({**greys, "empty.png": empty}, BOARD, told.append)

    assert list(fit.left_out) == ["empty.png"]
    assert "no complete chessboard of 9 x 6" in fit.left_out["empty.png"]
    assert told == [*greys, "empty.png"]


def test_a_picture_that_fits_worse_than_the_others_is_named(greys):
    bent = np.roll(greys["3.png"], 5, axis=1)
    rows = np.arange(360)
    shifts = np.round(1.2 * np.sin(rows / 50)).astype(int)
    bent = np.stack([np.roll(row, shift) for row, shift in zip(bent, shifts, strict=True)])
    fit = fit_lens({**greys, "bent.png": bent}, BOARD)

    assert fit.odd == ("bent.png",)


def test_too_few_pictures_are_refused(greys):
    few = dict(list(greys.items())[:4])
    said = fault(few)

    assert "only 4 of 4 pictures show the complete board of 9 x 6 inner corners" in said
    assert "a lens needs 5 or more" in said


def test_a_board_of_another_size_is_refused_with_what_is_seen(greys):
    said = fault(dict(list(greys.items())[:2]), Board(10, 7, 25))

    assert "none of 2 pictures shows a complete board of 10 x 7 inner corners" in said
    assert "only 9 x 6 of one" in said and "one less than squares" in said


@pytest.mark.soak
def test_boards_that_are_all_held_alike_tell_no_focal_length():
    random = np.random.default_rng(3)
    alike = {
        f"{n}.png": photograph(LENS, stand(TRUTH.middle(), 500 + n, 0.2), TRUTH, random)[0]
        for n in range(5)
    }

    assert "hold the board at 20 to 45 degrees" in fault(alike)


def test_two_eyes_are_measured_together_and_see_depth_afterwards(pairs):
    fit = fit_pair(pairs, BOARD)
    camera = fit.camera
    place = places(1, seed=7)[0]
    left, _ = photograph(LENS, place, TRUTH, np.random.default_rng(4))
    right, _ = photograph(RIGHT, place.beside(BASELINE), TRUTH, np.random.default_rng(5))
    colours = [np.repeat(one[..., None], 3, axis=-1) for one in (left, right)]
    view = StereoView.of(*colours, camera)
    rig, *_ = rectification(camera)

    assert fit.rms_px < 0.3
    assert camera.shift_mm == pytest.approx([-BASELINE, 0, 0], abs=2)
    assert np.degrees(np.arccos((np.trace(camera.turn) - 1) / 2)) < 0.4
    assert rig.baseline_mm == pytest.approx(BASELINE, abs=0.5)
    # Rows that are rectified agree: each corner lies in the same row of both pictures.
    ours, theirs = (find_corners(one, BOARD) for one in (view.grey, view.right[..., 0].copy()))
    theirs = min((theirs, theirs[::-1, ::-1]), key=lambda one: np.abs(one - ours).sum())
    assert np.abs((ours - theirs)[..., 1]).max() < 0.5


def test_pairs_whose_eyes_do_not_belong_together_are_refused(pairs):
    names = list(pairs)
    mixed = {name: (pairs[name][0], pairs[names[n - 1]][1]) for n, name in enumerate(names)}
    with pytest.raises(LensFault, match="were both pictures of a pair taken at the same time"):
        fit_pair(mixed, BOARD)
