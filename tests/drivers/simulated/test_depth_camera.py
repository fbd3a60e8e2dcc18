"""The simulated depth camera finds its place, points and stones in pictures that it draws itself."""

import asyncio
import json
from pathlib import Path

import numpy as np
import pytest

from labrun.drivers.cameras.vision import measure
from labrun.drivers.cameras.vision.board import Board
from labrun.drivers.cameras.vision.view import StereoView
from labrun.drivers.driver import ActionFailed, GoalContext, Place
from labrun.drivers.find import check_driver
from labrun.drivers.simulated.depth_camera import SimDepthCamera
from labrun.drivers.world import World
from labrun.schemas.contracts import shipped_contracts

pytestmark = pytest.mark.slow

STONE = [350, 400, 60, 40, 25]


def camera(folder: Path, **config) -> SimDepthCamera:
    place = Place("camera", {"clock": "fast", **config}, {}, folder / "camera", folder)
    return SimDepthCamera(place)


def played(twin: SimDepthCamera, story):
    async def play():
        await twin.open()
        try:
            return await story(twin)
        finally:
            await twin.close()

    return asyncio.run(play())


async def calibrated(twin: SimDepthCamera, goal: str = "c1"):
    return await twin.calibrate(GoalContext(goal), x=100, y=300)


def failed(twin: SimDepthCamera, story) -> ActionFailed:
    with pytest.raises(ActionFailed) as found:
        played(twin, story)
    return found.value


def test_it_keeps_its_contract():
    check_driver(SimDepthCamera, shipped_contracts()["depth_camera@1"])


@pytest.mark.soak
def test_it_finds_its_place_above_the_bench_to_a_millimetre(tmp_path):
    found = played(camera(tmp_path), calibrated)

    assert found["rms"] < 0.3
    assert (found["x"], found["y"], found["z"]) == pytest.approx((200, 70, 500), abs=1)
    assert found["tilt"] == pytest.approx(30, abs=0.2)


@pytest.mark.soak
def test_numbers_that_come_as_whole_ones_are_as_good(tmp_path):
    async def story(twin):
        goal = GoalContext("c1")
        return await twin.calibrate(goal, columns=9, rows=6, square=25, x=100, y=300)

    assert played(camera(tmp_path), story)["rms"] < 0.3


@pytest.mark.soak
def test_a_camera_on_a_gantry_goes_where_the_gantry_goes(tmp_path):
    World(tmp_path).publish("stage", {"x": 140.0, "y": 10.0, "z": 100.0})
    found = played(camera(tmp_path, gantry="stage"), calibrated)

    assert (found["x"], found["y"], found["z"]) == pytest.approx((200, 50, 500), abs=1)


@pytest.mark.soak
def test_a_calibration_holds_no_more_when_the_gantry_has_moved(tmp_path):
    world = World(tmp_path)
    world.publish("stage", {"x": 140.0, "y": 10.0, "z": 100.0})

    async def story(twin):
        await calibrated(twin)
        world.publish("stage", {"x": 141.0, "y": 10.0, "z": 100.0})
        await twin.locate_point(GoalContext("p1"), u=640, v=360)

    failure = failed(camera(tmp_path, gantry="stage"), story)

    assert failure.name == "NotCalibrated"
    assert "moved by 1.00 mm" in failure.message


@pytest.mark.soak
def test_a_calibration_outlives_its_server(tmp_path):
    played(camera(tmp_path), calibrated)

    async def story(twin):
        status = await twin.status()
        point = await twin.locate_point(GoalContext("p1"), u=640, v=360, height=0)
        return status, point

    status, point = played(camera(tmp_path), story)

    assert status["calibrated"] and 0 < status["rms"] < 0.3
    assert point["z"] == pytest.approx(0)


def test_a_place_of_known_height_is_found_within_the_uncertainty_that_is_told(tmp_path):
    async def story(twin):
        await calibrated(twin)
        u, v = twin.eyes.pose().project(np.array([380.0, 420.0, 25.0]), twin.eyes.rig.eye)
        return await twin.locate_point(GoalContext("p1"), u=float(u), v=float(v), height=25)

    point = played(camera(tmp_path, stones=[STONE]), story)
    away = np.hypot(point["x"] - 380, point["y"] - 420)

    assert away < min(0.9, point["uncertainty"])
    assert point["uncertainty"] < 2


@pytest.mark.soak
def test_without_a_height_the_two_eyes_tell_it(tmp_path):
    async def story(twin):
        await calibrated(twin)
        u, v = twin.eyes.pose().project(np.array([380.0, 420.0, 25.0]), twin.eyes.rig.eye)
        return await twin.locate_point(GoalContext("p1"), u=float(u), v=float(v))

    point = played(camera(tmp_path, stones=[STONE]), story)

    assert (point["x"], point["y"], point["z"]) == pytest.approx((380, 420, 25), abs=2)


@pytest.mark.soak
def test_stones_are_found_where_they_lie_and_nothing_else_is(tmp_path):
    async def story(twin):
        await calibrated(twin)
        return await twin.locate_samples(GoalContext("s1"))

    stones = [STONE, [400, 300, 30, 30, 12]]
    samples = played(camera(tmp_path, stones=stones), story)["samples"]
    found = [(s["x"], s["y"], s["height"]) for s in samples]

    assert found[0] == pytest.approx((380, 420, 25), abs=3)
    assert found[1] == pytest.approx((415, 315, 12), abs=3)
    assert len(found) == 2
    assert all(len(sample["outline"]) >= 3 for sample in samples)


def test_a_capture_is_a_colour_picture_and_a_depth_map_in_tenths_of_a_millimetre(tmp_path):
    import cv2

    async def story(twin):
        goal = GoalContext("1")
        told = await twin.capture(goal, image="a.png", depth="d.png")
        small = GoalContext("2")
        await twin.capture(small, image="a.JPG")
        assert small.files["image"].data.startswith(b"\xff\xd8\xff")
        return told, goal.files, twin.eyes.pose()

    told, files, pose = played(camera(tmp_path), story)
    picture, depth = (
        cv2.imdecode(np.frombuffer(files[name].data, np.uint8), cv2.IMREAD_UNCHANGED)
        for name in ("image", "depth")
    )
    ahead = pose.place_mm[2] / -pose.turn[2, 2]  # to the bench, along the line of sight

    assert told == {"image": "a.png", "depth": "d.png", "width": 1280, "height": 720}
    assert picture.shape == (720, 1280, 3)
    assert depth.dtype == np.uint16
    assert np.median(depth[340:380, 620:660]) / 10 == pytest.approx(ahead, abs=4)


@pytest.mark.soak
def test_the_same_goal_sees_the_same_picture_and_another_one_other_noise(tmp_path):
    async def story(twin):
        seen = []
        for name in ("1", "1", "2"):
            goal = GoalContext(name)
            await twin.capture(goal, image="a.png")
            seen.append(goal.files["image"].sha256)
        return seen

    first, again, other = played(camera(tmp_path), story)

    assert first == again != other


@pytest.mark.soak
@pytest.mark.parametrize(
    ("trouble", "error"),
    [
        ("covered", "BoardNotFound"),
        ("blurred", "BoardNotFound"),
        ("mirrored", "BoardMirrored"),
        ("shaken", "PoorFit"),
        ("one_eyed", "BoardNotFound"),
    ],
)
def test_a_board_that_is_seen_badly_calibrates_nothing(tmp_path, trouble, error):
    twin = camera(tmp_path, trouble=trouble)
    failure = failed(twin, calibrated)

    assert failure.name == error
    assert twin.calibration is None


@pytest.mark.soak
@pytest.mark.parametrize("error", ["BoardNotFound", "BoardMirrored", "PoorFit", "CameraLost"])
def test_an_error_that_is_ordered_is_the_one_that_comes(tmp_path, error):
    for number in range(2):
        twin = camera(tmp_path, faults={"calibrate": {error: 1}})
        failure = failed(twin, lambda twin, n=number: calibrated(twin, f"c{n}"))

        assert failure.name == error


@pytest.mark.soak
def test_eyes_that_are_exchanged_are_found_out(tmp_path):
    twin = camera(tmp_path)
    view = twin.eyes.look("1", None)
    exchanged = StereoView(view.right, view.picture, view.rig)
    with pytest.raises(ActionFailed, match=r"BoardMirrored: .*eyes are swapped"):
        measure.calibrate(exchanged, Board(x_mm=100, y_mm=300))


@pytest.mark.soak
def test_squares_of_another_size_than_is_said_are_found_out(tmp_path):
    async def story(twin):
        await twin.calibrate(GoalContext("c1"), square=30, x=100, y=300)

    failure = failed(camera(tmp_path), story)

    assert failure.name == "PoorFit"
    assert "size of its squares" in failure.message


@pytest.mark.soak
def test_points_need_a_calibration_a_pixel_in_the_picture_and_two_open_eyes(tmp_path):
    async def uncalibrated(twin):
        await twin.locate_point(GoalContext("p1"), u=1, v=1)

    async def outside(twin):
        await calibrated(twin)
        await twin.locate_point(GoalContext("p1"), u=1280, v=1)

    async def blind(twin):
        await calibrated(twin)
        twin.trouble = "one_eyed"
        await twin.locate_point(GoalContext("p1"), u=640, v=360)

    assert failed(camera(tmp_path), uncalibrated).name == "NotCalibrated"
    assert failed(camera(tmp_path), outside).name == "OutsidePicture"
    assert failed(camera(tmp_path), blind).name == "NoDepth"


@pytest.mark.soak
def test_what_it_really_did_is_logged(tmp_path):
    played(camera(tmp_path), calibrated)
    (line,) = (tmp_path / "truth" / "camera.jsonl").read_text().splitlines()

    assert json.loads(line)["place"] == [200, 70, 500]


@pytest.mark.parametrize(
    ("config", "words"),
    [
        ({"boards": 2}, "config has no key boards"),
        ({"board": {"size": 3}}, "board has no key size; its keys are: columns"),
        ({"place": {"tilted": 3}}, "place has no key tilted; its keys are: x, y, z, tilt"),
        ({"trouble": "tired"}, "trouble is 'tired'; it must be one of: covered"),
    ],
)
def test_a_configuration_that_cannot_be_is_refused_in_words(tmp_path, config, words):
    with pytest.raises(ValueError, match=words):
        camera(tmp_path, **config)
