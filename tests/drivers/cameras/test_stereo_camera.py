"""The real depth camera, on folders and films of photographs whose truth is known."""

import asyncio
import json
import os
from pathlib import Path

import cv2
import numpy as np
import pytest
from scenes import Chessboard, Lens, photograph, stand

from labrun.drivers.cameras.stereo_camera import StereoCamera
from labrun.drivers.cameras.video import CameraVideo
from labrun.drivers.cameras.vision.camera import Camera
from labrun.drivers.cameras.vision.camera_file import write_camera
from labrun.drivers.cameras.vision.intrinsics import Intrinsics
from labrun.drivers.driver import ActionFailed, GoalContext, Place
from labrun.drivers.find import check_driver, find_driver
from labrun.schemas.contracts import shipped_contracts

from ..played import played

LENS = Lens(640, 360, 532.5, (322.0, 176.0), (-0.05, 0.02, 0.0005, 0.0004, 0.0))
TRUTH = Chessboard()
PLACE = stand(TRUTH.middle(), 520, 30, 4)
BASELINE = 60.0
AT = {"x": 100, "y": 300}


@pytest.fixture(scope="module")
def photos():
    """Left, right, and the left one's depth; the bench is grainy, as eyes need something to see."""
    random = np.random.default_rng(1)
    taken = [photograph(LENS, eye, TRUTH, random) for eye in (PLACE, PLACE.beside(BASELINE))]
    left, right = (np.repeat(grey[..., None], 3, axis=-1) for grey, _ in taken)
    return left, right, taken[0][1]


def lens_file(folder: Path, *, two: bool = False) -> str:
    eye = Intrinsics(LENS.width, LENS.height, LENS.matrix(), np.array(LENS.distortion))
    beside = (
        {"right": eye, "turn": np.eye(3), "shift_mm": np.array([-BASELINE, 0, 0])} if two else {}
    )
    write_camera(folder / "cam.yaml", Camera(eye, **beside))
    return str(folder / "cam.yaml")


def camera(base: Path, /, **config) -> StereoCamera:
    (base / "own").mkdir(exist_ok=True)
    known = {"camera": lens_file(base, two=config.pop("two", False)), **config}
    return StereoCamera(Place("camera", known, {}, base / "own", base))


def written(folder: Path, name: str, picture) -> None:
    (folder / "pictures").mkdir(exist_ok=True)
    assert cv2.imwrite(str(folder / "pictures" / name), picture)


def film(path: Path, pictures) -> str:
    height, width = pictures[0].shape[:2]
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"FFV1"), 10, (width, height))
    for picture in pictures:
        writer.write(picture)
    writer.release()
    return str(path)


def failed(driver: StereoCamera, story) -> ActionFailed:
    with pytest.raises(ActionFailed) as found:
        played(driver, story)
    return found.value


async def calibrated(driver):
    return await driver.calibrate(GoalContext("c"), **AT)


def pixel(x: float, y: float) -> dict[str, float]:
    u, v = LENS.pixels(PLACE.seen(np.array([x, y, 0.0])))
    return {"u": float(u), "v": float(v)}


def test_it_keeps_its_contract_and_is_found_by_its_name(tmp_path):
    assert find_driver("stereo_camera", tmp_path) is StereoCamera
    check_driver(StereoCamera, shipped_contracts()["depth_camera@1"])


@pytest.mark.slow
def test_a_folder_with_a_picture_and_its_depth_map_does_all_that_the_contract_says(
    tmp_path, photos
):
    left, _, depth = photos
    slab = left.copy()
    corners = LENS.pixels(
        PLACE.seen(np.array([[370, 300, 0], [410, 300, 0], [410, 350, 0], [370, 350, 0.0]]))
    )
    cv2.fillPoly(slab, [np.round(corners).astype(np.int32)], (60, 60, 190))
    written(tmp_path, "a_depth.png", np.round(depth * 10).astype(np.uint16))
    written(tmp_path, "a.png", slab)

    async def story(driver):
        goal = GoalContext("1")
        told = await driver.capture(goal, image="i.png", depth="d.png")
        place = await calibrated(driver)
        point = await driver.locate_point(GoalContext("2"), **pixel(200, 260))
        level = await driver.locate_point(GoalContext("3"), **pixel(200, 260), height=0)
        samples = await driver.locate_samples(GoalContext("4"))
        return told, goal.files, place, point, level, samples["samples"], await driver.status()

    told, files, place, point, level, samples, status = played(
        camera(tmp_path, folder=str(tmp_path / "pictures")), story
    )

    assert told == {"image": "i.png", "depth": "d.png", "width": 640, "height": 360}
    kept = cv2.imdecode(np.frombuffer(files["depth"].data, np.uint8), cv2.IMREAD_UNCHANGED)
    assert kept.dtype == np.uint16 and kept[180, 320] / 10 == pytest.approx(
        depth[180, 320], abs=0.1
    )
    assert [place[axis] for axis in "xyz"] == pytest.approx(PLACE.place, abs=1)
    assert (point["x"], point["y"], point["z"]) == pytest.approx((200, 260, 0), abs=0.7)
    assert (level["x"], level["y"], level["z"]) == pytest.approx((200, 260, 0), abs=0.4)
    assert [(round(s["x"]), round(s["y"])) for s in samples] == [(390, 325)]
    assert samples[0]["area"] == pytest.approx(2000, rel=0.15)
    assert status["connected"] and status["calibrated"] and 0 < status["rms"] < 0.3


@pytest.mark.slow
def test_the_newest_picture_counts(tmp_path, photos):
    written(tmp_path, "b.png", photos[0])
    written(tmp_path, "a.png", photos[0] * 0)
    os.utime(tmp_path / "pictures" / "a.png", (1, 1))
    driver = camera(tmp_path, folder=str(tmp_path / "pictures"))

    assert played(driver, calibrated)["rms"] < 0.3
    os.utime(tmp_path / "pictures" / "b.png", (0, 0))
    assert failed(driver, calibrated).name == "BoardNotFound"


def test_where_the_camera_is_outlives_its_server_but_not_another_lens(tmp_path, photos):
    written(tmp_path, "a.png", photos[0])
    config = {"folder": str(tmp_path / "pictures")}
    played(camera(tmp_path, **config), calibrated)

    async def status(driver):
        return await driver.status()

    assert played(camera(tmp_path, **config), status)["calibrated"]
    (tmp_path / "cam.yaml").rename(tmp_path / "other.yaml")
    other = str(tmp_path / "other.yaml")
    place = Place("camera", {"camera": other, **config}, {}, tmp_path / "own", tmp_path)
    assert not played(StereoCamera(place), status)["calibrated"]
    (tmp_path / "own" / "calibration.json").write_text("torn {")
    assert not played(camera(tmp_path, **config), status)["calibrated"]


def test_two_pictures_are_rectified_and_checked_against_each_other(tmp_path, photos):
    left, right, _ = photos
    written(tmp_path, "a_left.png", left)
    written(tmp_path, "a_right.png", right)
    driver = camera(tmp_path, two=True, folder=str(tmp_path / "pictures"))
    place = played(driver, calibrated)

    assert [place[axis] for axis in "xyz"] == pytest.approx(PLACE.place, abs=1)
    written(tmp_path, "a_left.png", right)
    written(tmp_path, "a_right.png", left)
    failure = failed(driver, calibrated)
    assert failure.name == "BoardMirrored" and "eyes are swapped" in failure.message


def test_a_film_of_both_eyes_side_by_side_gives_one_look_after_the_other(tmp_path, photos):
    both = np.concatenate(photos[:2], axis=1)
    path = film(tmp_path / "film.avi", [both, both * 0])

    async def story(driver):
        first = await calibrated(driver)
        with pytest.raises(ActionFailed) as dark:
            await calibrated(driver)
        with pytest.raises(ActionFailed) as over:
            await calibrated(driver)
        return first, dark.value.name, over.value, await driver.status()

    first, dark, over, status = played(camera(tmp_path, two=True, device=path), story)

    assert [first[axis] for axis in "xyz"] == pytest.approx(PLACE.place, abs=1)
    assert dark == "BoardNotFound"
    assert over.name == "CameraLost" and "has no more pictures" in over.message
    assert not status["connected"] and status["calibrated"]


def test_other_actions_are_answered_while_a_picture_is_worked_on(tmp_path, photos):
    written(tmp_path, "a.png", photos[0])

    async def story(driver):
        work = asyncio.create_task(calibrated(driver))
        answers = 0
        while not work.done():
            await asyncio.sleep(0)
            answers += (await driver.status())["calibrated"] is False
        return answers, await work

    answers, _ = played(camera(tmp_path, folder=str(tmp_path / "pictures")), story)

    assert answers > 10


def test_a_folder_that_holds_no_picture_or_broken_ones_loses_the_camera(tmp_path, photos):
    (tmp_path / "pictures").mkdir()
    driver = camera(tmp_path, folder=str(tmp_path / "pictures"))
    empty = failed(driver, calibrated)
    (tmp_path / "pictures" / "a.png").write_text("no picture")
    broken = failed(driver, calibrated)
    written(tmp_path, "b_left.png", photos[0])
    alone = failed(driver, calibrated)
    (tmp_path / "pictures" / "b_left.png").unlink()
    written(tmp_path, "c.png", photos[0][:200])
    small = failed(driver, calibrated)

    assert {empty.name, broken.name, alone.name, small.name} == {"CameraLost"}
    assert "there is no picture in the folder" in empty.message
    assert "a.png is not a picture" in broken.message
    assert "without b_right beside it" in alone.message
    assert "pictures of 640 x 360, and this one is 640 x 200" in small.message


def test_a_depth_map_of_another_size_is_said(tmp_path, photos):
    written(tmp_path, "a.png", photos[0])
    written(tmp_path, "a_depth.png", np.ones((100, 200), np.uint16))
    failure = failed(camera(tmp_path, folder=str(tmp_path / "pictures")), calibrated)

    assert failure.name == "NoDepth"
    assert "the depth map is 200 x 100, and the picture is 640 x 360" in failure.message


def test_points_and_samples_need_a_calibration(tmp_path, photos):
    written(tmp_path, "a.png", photos[0])
    driver = camera(tmp_path, folder=str(tmp_path / "pictures"))

    assert (
        failed(driver, lambda d: d.locate_point(GoalContext("1"), u=1, v=1)).name == "NotCalibrated"
    )
    assert failed(driver, lambda d: d.locate_samples(GoalContext("1"))).name == "NotCalibrated"


@pytest.mark.parametrize(
    ("config", "words"),
    [
        ({"device": 63}, r"there is no camera /dev/video63"),
        ({"device": "/dev/video63"}, r"there is no camera /dev/video63"),
        ({"device": "/dev/null"}, r"/dev/null is there but cannot be opened: another program"),
        ({"folder": "/none/at/all"}, r"the picture folder /none/at/all is missing"),
    ],
)
def test_a_camera_that_cannot_be_reached_is_an_oserror_with_a_sentence(
    tmp_path, config, words, capfd
):
    with pytest.raises(OSError, match=words):
        played(camera(tmp_path, **config), calibrated)

    assert capfd.readouterr() == ("", "")


def test_a_text_that_is_called_a_film_is_none(tmp_path):
    (tmp_path / "film.avi").write_text("no film")
    with pytest.raises(OSError, match=r"film.avi is not a readable video file"):
        CameraVideo(str(tmp_path / "film.avi")).open()


def test_a_lens_file_that_is_none_is_an_oserror_with_a_sentence(tmp_path):
    (tmp_path / "bad.yaml").write_text("hello")
    (tmp_path / "pictures").mkdir()
    driver = StereoCamera(
        Place(
            "c",
            {"camera": str(tmp_path / "bad.yaml"), "folder": str(tmp_path / "pictures")},
            {},
            tmp_path,
            tmp_path,
        )
    )
    with pytest.raises(OSError, match=r"bad.yaml: this does not describe a camera"):
        played(driver, calibrated)


@pytest.mark.parametrize(
    ("config", "words"),
    [
        ({}, "either `device` or `folder`"),
        ({"device": 0, "folder": "."}, "either `device` or `folder`"),
        ({"folder": ".", "colour": 1}, "config has no key colour; its keys are: camera, device"),
        ({"folder": ".", "x_runs": "north"}, "x_runs is 'north'; it must be one of: right"),
        ({"folder": ".", "depth_unit": 0}, "depth_unit is 0"),
        ({"device": 0, "size": 720}, "size is 720; write"),
    ],
)
def test_a_configuration_that_cannot_be_is_refused_in_words(tmp_path, config, words):
    with pytest.raises(ValueError, match=words):
        camera(tmp_path, **config)


def test_it_serves_over_the_wire_as_any_device_does(tmp_path, photos):
    from labrun.drivers.client.client import DeviceClient
    from labrun.drivers.server.serve import serving
    from labrun.drivers.server.settings import ServerSettings
    from labrun.schemas.messages import Goal

    written(tmp_path, "a.png", photos[0])
    contract = shipped_contracts()["depth_camera@1"].model_dump(mode="json")
    config = {"camera": lens_file(tmp_path), "folder": str(tmp_path / "pictures")}
    device = {"contract": contract, "driver": "stereo_camera", "config": config}
    settings = {"devices": {"camera": device}, "folder": str(tmp_path / "server")}

    async def story():
        async with serving(ServerSettings.model_validate(settings)) as (_, url):
            client = DeviceClient(url)
            await client.open()
            try:
                await client.take_lease("camera", "test")
                goal = Goal.model_validate({
                    "id": "r/main/1/1", "boot": client.boot, "epoch": client.epoch("camera"),
                    "device": "camera", "action": "calibrate", "params": AT,
                })  # fmt: skip
                return await asyncio.wait_for(client.follow(goal), 500)
            finally:
                await client.close()

    outcome = asyncio.run(story())

    assert json.loads(json.dumps(outcome.result))["rms"] < 0.3
