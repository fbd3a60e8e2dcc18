"""Boards that lie as people lay them: turned, on a plate; found by corners that were touched."""

import math

import numpy as np
import pytest
from scenes import Chessboard
from vision import LYING, WANTED, as_touched_scene, touches

from labrun.drivers.cameras.vision.board import Board
from labrun.drivers.cameras.vision.pose import Calibration, Pose
from labrun.drivers.cameras.vision.touched_points import Lying, as_touched
from labrun.drivers.driver import ActionFailed


@pytest.mark.parametrize(("angle", "height"), LYING)
@pytest.mark.parametrize("count", [2, 3])
def test_touched_corners_say_how_a_board_lies(angle, height, count):
    truth = Chessboard(angle=angle, height=height)
    random = np.random.default_rng(3)
    board, lying = as_touched(Board(), touches(truth, random, count), 0.2)
    away = np.linalg.norm(board.corners_mm() - truth.corners(), axis=-1)

    assert away.max() < 1.0
    assert board.angle_deg == pytest.approx(angle, abs=0.2)
    assert board.height_mm == pytest.approx(height, abs=0.5)
    assert 0.05 < lying.xy_mm < 0.4 and 0 < math.degrees(lying.angle) < 0.15


def test_an_exact_touch_gives_the_exact_board():
    truth = Chessboard(x=10, y=-20, angle=88, height=12.7)
    corners = truth.corners()
    touched = [
        {"column": c, "row": r, **dict(zip("xyz", corners[r, c], strict=True))}
        for c, r in ((0, 0), (8, 5))
    ]
    board, _ = as_touched(Board(), touched, 0.2)

    assert board.corners_mm() == pytest.approx(corners)


def touch(column, row, x, y, **more):
    return {"column": column, "row": row, "x": x, "y": y, **more}


@pytest.mark.parametrize(
    ("touched", "words"),
    [
        ([touch(0, 0, 0, 0), touch(0, 0, 1, 1)], "two different corners"),
        ([touch(0, 0, 0, 0), touch(9, 0, 225, 0)], "no inner corner at column 9, row 0"),
        ([touch(0, 0, 0, 0), touch(8, 0, 210, 0)], "5.0% wider together: is a square 25 mm"),
        ([touch(0, 0, 0, 0), touch(8, 0, 0, 200), touch(8, 5, 125, 200)], "inner corners touched"),
        (
            [touch(0, 0, 0, 0, z=0), touch(8, 0, 200, 0, z=3)],
            "not level: it was touched from z 0.00",
        ),
    ],
)
def test_touched_points_that_cannot_be_the_boards_are_refused(touched, words):
    with pytest.raises(ActionFailed, match=words):
        as_touched(Board(), touched, 0.2)


def test_how_a_board_lies_is_kept_with_the_calibration_and_older_files_are_read():
    board = Board(9, 6, 25, 1, 2, 88, 12.7)
    fit = Calibration(
        Pose.looking((0, 0, 500), 30),
        0.1,
        np.zeros(3),
        np.eye(6),
        board,
        Lying((3, 4), 0.1, 0.001, 0.2),
    )
    kept = fit.to_dict()
    old = {**kept, "board": kept["board"][:5]}
    del old["lying"]

    assert Calibration.from_dict(kept).board == board
    assert Calibration.from_dict(kept).lying == fit.lying
    assert Calibration.from_dict(old).board == Board(9, 6, 25, 1, 2)
    assert Calibration.from_dict(old).lying == Lying()


@pytest.mark.soak
def test_positions_beside_twelve_boards_are_as_near_as_wanted_and_as_told():
    """At 7, -12 and 88 degrees among others, flat and on a 12.7 mm plate, photographed."""
    random = np.random.default_rng(12)
    rows = [row for angle, height in LYING for row in as_touched_scene(angle, height, random, 20)]
    table = np.array(rows, float)
    most = np.percentile(table[:, :3], 95, axis=0)

    assert len(rows) == 240
    assert most[0] < WANTED["XY by depth"]
    assert most[1] < WANTED["Z by depth"]
    assert most[2] < WANTED["XY, height known"]
    assert table[:, 3].mean() >= 0.95 and table[:, 4].mean() >= 0.95
