"""Simulated eyes: what is drawn lies where geometry says."""

import numpy as np
import pytest

from labrun.drivers.cameras.vision.board import Board, corners_on_bench, find_corners
from labrun.drivers.cameras.vision.intrinsics import Intrinsics
from labrun.drivers.cameras.vision.pixel_position import point_at_depth, point_at_height
from labrun.drivers.cameras.vision.pose import Pose
from labrun.drivers.simulated.twins.camera import Eyes
from labrun.drivers.simulated.twins.camera_eye import see
from labrun.drivers.simulated.twins.camera_scene import Scene, Stone
from labrun.drivers.simulated.twins.camera_trouble import spoil
from labrun.drivers.world import World

EYE = Intrinsics.ideal(1280, 720, 1065.0)
MIDDLE = 639.5, 359.5


def test_a_camera_that_looks_straight_down_sees_bench_x_to_the_right_and_y_up():
    pose = Pose.looking((100, 200, 500), 0)
    middle, right, up = pose.project(np.array([[100, 200, 0], [110, 200, 0], [100, 210, 0]]), EYE)

    assert middle == pytest.approx(MIDDLE)
    assert right - middle == pytest.approx((21.3, 0))
    assert up - middle == pytest.approx((0, -21.3))


def test_a_tilted_camera_looks_further_along_y_and_knows_its_tilt():
    pose = Pose.looking((0, 0, 500), 30)
    x, y, z = point_at_height(pose, EYE, *MIDDLE, 0)

    assert pose.tilt_deg == pytest.approx(30)
    assert (x, y, z) == pytest.approx((0, 500 * np.tan(np.radians(30)), 0))


def test_a_pixel_at_its_depth_is_the_point_that_was_projected():
    pose, point = Pose.looking((50, 20, 480), 25), np.array([80.0, 260.0, 12.0])
    u, v = pose.project(point, EYE)
    depth = float((point - pose.place_mm) @ pose.turn[2])

    assert point_at_depth(pose, EYE, u, v, depth) == pytest.approx(point)


@pytest.mark.parametrize("tilt", [20, 30, 40])
def test_the_corners_of_the_board_are_drawn_where_they_belong(tilt):
    import cv2

    board = Board(9, 6, 25, 100, 300)
    pose = Pose.looking((200, 360 - 500 * np.tan(np.radians(tilt)), 500), tilt)
    grey = cv2.cvtColor(see(Scene(board, (), 3), pose, EYE), cv2.COLOR_BGR2GRAY)
    away = (
        corners_on_bench(grey, find_corners(grey, board))
        - pose.project(board.corners_mm(), EYE)[..., :2]
    )

    assert np.abs(away).max() < 0.6
    assert np.sqrt((away**2).mean()) < 0.15


def test_a_stone_hides_what_lies_behind_it():
    pose = Pose.looking((200, 70, 500), 30)
    bare, stone = (
        see(Scene(None, stones, 3), pose, EYE) for stones in ((), (Stone(180, 340, 40, 30, 40),))
    )
    u, v = np.round(pose.project(np.array([200.0, 355.0, 40.0]), EYE)).astype(int)

    assert not np.array_equal(bare[v, u], stone[v, u])
    assert np.array_equal(bare[:, :200], stone[:, :200])


def test_the_eyes_ride_on_the_gantry_that_the_world_shows(tmp_path):
    world = World(tmp_path)
    eyes = Eyes({"gantry": "stage", "place": {"x": 10, "y": 20, "z": 300}}, world, 1)
    before = eyes.pose().place_mm
    world.publish("stage", {"x": 1.5, "y": 2.5, "z": 100.0})

    assert before == pytest.approx((10, 20, 300))
    assert eyes.pose().place_mm == pytest.approx((11.5, 22.5, 400))


def test_a_trouble_that_no_camera_has_is_refused():
    picture = np.zeros((8, 8, 3), np.uint8)
    with pytest.raises(ValueError, match="'tired' is not a camera trouble"):
        spoil((picture, picture), "tired", None)
