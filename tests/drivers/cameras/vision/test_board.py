"""The board in a picture: in which order its corners lie on the bench, and when that is refused."""

import numpy as np
import pytest
from scenes import Chessboard, Lens, photograph, stand

from labrun.drivers.cameras.vision.board import Board, corners_on_bench, find_corners
from labrun.drivers.driver import ActionFailed

LENS = Lens(640, 360, 532.5, (319.5, 179.5))
TRUTH = Chessboard()
BOARD = Board(9, 6, 25, 100, 300)
PLACE = stand(TRUTH.middle(), 480, 30, 5)


@pytest.fixture(scope="module")
def grey():
    return photograph(LENS, PLACE, TRUTH, np.random.default_rng(1))[0]


def failed(grey, board=BOARD, x_runs="right") -> ActionFailed:
    with pytest.raises(ActionFailed) as found:
        corners_on_bench(grey, find_corners(grey, board), x_runs)
    return found.value


def test_every_corner_is_found_where_it_is(grey):
    away = corners_on_bench(grey, find_corners(grey, BOARD)) - LENS.pixels(
        PLACE.seen(TRUTH.corners())
    )

    assert np.sqrt((away**2).mean()) < 0.1
    assert np.abs(away).max() < 0.3


@pytest.mark.parametrize(
    ("x_runs", "roll"), [("right", 0), ("up", 90), ("left", 180), ("down", -90)]
)
def test_bench_x_may_run_any_way_in_the_picture_if_it_is_said(x_runs, roll):
    place = stand(TRUTH.middle(), 520, 25, 0, roll)
    grey, _ = photograph(LENS, place, TRUTH)
    away = corners_on_bench(grey, find_corners(grey, BOARD), x_runs) - LENS.pixels(
        place.seen(TRUTH.corners())
    )

    assert np.hypot(*away.T).max() < 0.3


@pytest.mark.parametrize("change", [np.fliplr, lambda one: np.rot90(one, 2)])
def test_a_picture_that_is_mirrored_or_upside_down_is_refused(grey, change):
    failure = failed(np.ascontiguousarray(change(grey)))

    assert failure.name == "BoardMirrored"
    assert "mirrored, or the board or the picture is turned round" in failure.message


def test_a_picture_that_is_turned_by_90_degrees_is_refused(grey):
    failure = failed(np.ascontiguousarray(np.rot90(grey)))

    assert failure.name == "BoardMirrored"
    assert "turned by 90 degrees" in failure.message


def test_columns_and_rows_that_are_exchanged_are_found_out(grey):
    failure = failed(grey, Board(6, 9, 25, 100, 300))

    assert failure.name == "BoardMirrored"
    assert "a board of 9 x 6" in failure.message


def test_a_picture_without_a_board_is_refused():
    failure = failed(np.random.default_rng(1).integers(0, 255, (360, 640)).astype(np.uint8))

    assert failure.name == "BoardNotFound"
    assert "no complete chessboard of 9 x 6 inner corners" in failure.message


def test_of_a_board_that_is_covered_or_of_another_size_it_is_said_what_is_seen(grey):
    covered = grey.copy()
    corner = np.round(LENS.pixels(PLACE.seen(TRUTH.corners()[0, 8]))).astype(int)
    covered[corner[1] - 20 : corner[1] + 20, corner[0] - 20 : corner[0] + 20] = 128
    for picture, board in ((covered, BOARD), (grey, Board(10, 7))):
        failure = failed(picture, board)

        assert failure.name == "BoardNotFound"
        assert "something covers the rest, it extends beyond the picture, or" in failure.message
    assert "only 9 x 6 of one" in failure.message
