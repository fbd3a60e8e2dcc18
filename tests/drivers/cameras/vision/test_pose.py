"""Where a camera is by its board: near the truth, with the sureness that it says, or refused."""

import numpy as np
import pytest
from scenes import Chessboard, Lens, stand

from labrun.drivers.cameras.vision.board import Board
from labrun.drivers.cameras.vision.intrinsics import Intrinsics
from labrun.drivers.cameras.vision.pose import Calibration, fit_pose
from labrun.drivers.driver import ActionFailed

LENS = Lens(distortion=(-0.06, 0.03, 0.001, -0.0005, 0.0))
EYE = Intrinsics(LENS.width, LENS.height, LENS.matrix(), np.array(LENS.distortion))
TRUTH, BOARD = Chessboard(), Board(9, 6, 25, 100, 300)


def corners(place, board=TRUTH, noise=0.0, seed=1):
    exact = LENS.pixels(place.seen(board.corners()))
    return exact + np.random.default_rng(seed).normal(0, noise, exact.shape)


def failed(seen, board=BOARD, eye=EYE) -> ActionFailed:
    with pytest.raises(ActionFailed) as found:
        fit_pose(seen, board, eye)
    return found.value


@pytest.mark.parametrize("tilt", [0, 20, 45, 60])
def test_exact_corners_give_the_exact_place(tilt):
    place = stand(TRUTH.middle(), 700, tilt, 10, 4)
    fit = fit_pose(corners(place), BOARD, EYE)

    assert fit.pose.place_mm == pytest.approx(place.place, abs=1e-3)
    assert fit.pose.turn == pytest.approx(place.turn, abs=1e-6)
    assert fit.pose.tilt_deg == pytest.approx(tilt, abs=1e-3)
    assert fit.rms_px < 1e-4


def test_ignoring_the_lens_s_distortion_costs_more_than_the_figure():
    place = stand(TRUTH.middle(), 500, 30)
    straight = Intrinsics(EYE.width, EYE.height, EYE.matrix, np.zeros(5))

    assert np.linalg.norm(fit_pose(corners(place), BOARD, straight).pose.place_mm - place.place) > 1


def test_the_place_is_as_sure_as_it_says():
    inside = 0
    for seed in range(60):
        place = stand(TRUTH.middle(), 800, 30, seed)
        fit = fit_pose(corners(place, noise=0.3, seed=seed), BOARD, EYE)
        # The covariance is of where the board's middle is seen: the last three are its shift.
        shift = place.seen(fit.about_mm) - (fit.about_mm - fit.pose.place_mm) @ fit.pose.turn.T
        inside += bool(np.all(np.abs(shift) < 2 * np.sqrt(np.diag(fit.covariance)[3:])))

    assert 45 <= inside <= 60


def test_a_calibration_is_kept_in_plain_numbers():
    fit = fit_pose(corners(stand(TRUTH.middle(), 700, 30), noise=0.2), BOARD, EYE)
    again = Calibration.from_dict(fit.to_dict())

    assert again.to_dict() == fit.to_dict()
    assert again.board == BOARD


def test_corners_in_a_mirrored_order_put_the_camera_under_the_bench():
    failure = failed(corners(stand(TRUTH.middle(), 700, 30))[:, ::-1])

    assert failure.name == "BoardMirrored"
    assert "under the bench: the picture is mirrored" in failure.message


def test_too_steep_an_angle_is_refused_with_the_angle():
    failure = failed(corners(stand(TRUTH.middle(), 700, 72)))

    assert failure.name == "PoorFit"
    assert "seen at 72 degrees from straight above" in failure.message


def test_corners_that_fit_no_flat_board_are_refused_with_their_error():
    bent = corners(stand(TRUTH.middle(), 500, 30))
    bent[2:4, 3:6] += 4
    failure = failed(bent)

    assert failure.name == "PoorFit"
    assert "pixels (rms) from where a flat board" in failure.message


def test_corners_on_one_line_fit_no_place():
    line = np.stack([np.linspace(100, 900, 54)] * 2, axis=-1).reshape(6, 9, 2)

    assert failed(line).name in ("PoorFit", "BoardMirrored")


def test_a_board_that_is_tiny_in_the_picture_fits_two_places_and_is_refused():
    tiny = Chessboard(9, 6, 2.0)
    names = set()
    for seed in range(6):
        seen = corners(stand(tiny.middle(), 900, 25), tiny, noise=0.5, seed=seed)
        try:
            fit_pose(seen, Board(9, 6, 2.0, 100, 300), EYE)
        except ActionFailed as failure:
            names.add(failure.name)

            assert "two camera positions" in failure.message
    assert names == {"PoorFit"}
