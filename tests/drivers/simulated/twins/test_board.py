"""The printed board: squares of the right size and colour, smooth at their edges."""

import numpy as np
import pytest

from labrun.drivers.cameras.vision.board import Board
from labrun.drivers.simulated.twins.board import BLACK, WHITE, plate_mm, print_onto

STRAIGHT_DOWN = np.array([[2.0, 0, 100], [0, -2.0, 300], [0, 0, 1]])  # 2 pixel a millimetre


def printed(board: Board) -> np.ndarray:
    picture = np.full((400, 600, 3), 100, np.uint8)
    print_onto(picture, board, STRAIGHT_DOWN)
    return picture[..., 0]


def shade(picture: np.ndarray, x: float, y: float) -> int:
    return int(picture[round(300 - 2 * y), round(100 + 2 * x)])


def test_the_square_outside_the_first_corner_is_black_and_its_neighbours_are_white():
    picture = printed(Board(5, 4, 20, 0, 0))

    assert shade(picture, -10, -10) == BLACK
    assert shade(picture, 10, -10) == shade(picture, -10, 10) == WHITE
    assert shade(picture, 10, 10) == BLACK


def test_the_plate_ends_a_little_outside_the_squares():
    board = Board(5, 4, 20, 0, 0)
    picture = printed(board)

    assert plate_mm(board)[0].tolist() == [-32, -32, 0]
    assert shade(picture, -25, 10) == WHITE
    assert shade(picture, -40, 10) == 100


def test_an_edge_through_a_pixel_is_grey():
    picture = printed(Board(5, 4, 20, 0.1, 0))

    assert shade(picture, -1, 10) == WHITE
    assert BLACK + 40 < shade(picture, 0, 10) < WHITE - 40
    assert shade(picture, 1, 10) == BLACK


@pytest.mark.parametrize("x", [-5000, 5000])
def test_a_board_beside_the_picture_leaves_it_alone(x):
    assert (printed(Board(5, 4, 20, x, 0)) == 100).all()
