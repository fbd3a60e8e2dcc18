"""A RealSense camera: recordings of its library's software device, of scenes whose truth is known."""

import sys

import numpy as np
import pytest
from scenes import Chessboard, Lens, photograph, stand

from labrun.drivers.cameras.realsense import RealSense, RealSenseDevice, eye_of, slow_port
from labrun.drivers.driver import GoalContext, Place

from ..played import played

try:
    import pyrealsense2 as rs
except ImportError:
    rs = None

pytestmark = pytest.mark.needs("libusb")

COLOUR = Lens(640, 360, 532.5, (322.0, 176.0))
DEPTH = Lens(640, 360, 420.0, (318.0, 181.0))
BOARD = Chessboard()
PLACE = stand(BOARD.middle(), 520, 30, 4)
APART, BASELINE = 15.0, 50.0
"""The colour eye is to the right of the one that sees depth; what the two eyes for depth are apart."""
TENTH_MM = 1e-4
PICTURES = 4


def known(lens, model="none", coeffs=(0.0,) * 5):
    told = rs.intrinsics()
    told.width, told.height, told.fx, told.fy = lens.width, lens.height, lens.focal, lens.focal
    (told.ppx, told.ppy), told.model, told.coeffs = (
        lens.middle,
        getattr(rs.distortion, model),
        list(coeffs),
    )
    return told


def stream(sensor, uid, kind, format, bytes, lens):
    told = rs.video_stream()
    told.type, told.fmt, told.bpp, told.uid, told.index, told.fps = kind, format, bytes, uid, 0, 30
    told.width, told.height, told.intrinsics = lens.width, lens.height, known(lens)
    return sensor.add_video_stream(told)


def frame(profile, pixels, bytes, number):
    told = rs.software_video_frame()
    told.pixels, told.bpp, told.stride = (
        np.ascontiguousarray(pixels),
        bytes,
        pixels.shape[1] * bytes,
    )
    told.timestamp, told.frame_number = 33.0 * number, number
    told.domain, told.profile = (
        rs.timestamp_domain.hardware_clock,
        profile.as_video_stream_profile(),
    )
    if bytes == 2:
        told.depth_units = TENTH_MM
    return told


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """As the library's recorder writes it."""
    path = tmp_path_factory.mktemp("realsense") / "bench.db3"
    grey, _ = photograph(COLOUR, PLACE, BOARD, np.random.default_rng(1))
    _, far = photograph(DEPTH, PLACE.beside(-APART), BOARD)
    device = rs.software_device()
    device.register_info(rs.camera_info.name, "Intel RealSense, simulated")
    device.register_info(rs.camera_info.serial_number, "0123")
    eyes, rgb = device.add_sensor("Stereo Module"), device.add_sensor("RGB Camera")
    eyes.add_read_only_option(rs.option.depth_units, TENTH_MM)
    eyes.add_read_only_option(rs.option.stereo_baseline, BASELINE)
    deep = stream(eyes, 1, rs.stream.depth, rs.format.z16, 2, DEPTH)
    colour = stream(rgb, 2, rs.stream.color, rs.format.rgb8, 3, COLOUR)
    between = rs.extrinsics()
    between.rotation, between.translation = [1, 0, 0, 0, 1, 0, 0, 0, 1], [-APART / 1000, 0, 0]
    deep.register_extrinsics_to(colour, between)
    recorder, heard = rs.recorder(str(path), device), rs.frame_queue(2 * PICTURES)
    sensors = recorder.query_sensors()
    for sensor, profile in zip(sensors, (deep, colour), strict=True):
        sensor.open(profile)
        sensor.start(heard)
    red = np.stack([grey, grey // 2, grey // 4], axis=-1)
    for number in range(1, PICTURES + 1):
        eyes.on_video_frame(frame(deep, np.round(far * 10).astype(np.uint16), 2, number))
        rgb.on_video_frame(frame(colour, red, 3, number))
        for _ in (deep, colour):
            heard.wait_for_frame(60_000)  # written as well
    for sensor in sensors:
        sensor.stop()
        sensor.close()
    return path


class Incomplete:
    """A pipeline that gives one picture without depth first, as over a busy port."""

    def __init__(self, pipeline):
        self.pipeline, self.left = pipeline, 2

    def wait_for_frames(self, ms):
        self.left -= 1
        return (
            rs.composite_frame(rs.frame()) if self.left >= 0 else self.pipeline.wait_for_frames(ms)
        )

    def stop(self):
        self.pipeline.stop()


def camera(folder, **config):
    (folder / "own").mkdir(exist_ok=True)
    return RealSense(Place("overview", config, {}, folder / "own", folder))


@pytest.mark.slow
def test_its_own_lens_and_its_depth_laid_onto_colour_find_a_place_on_the_bench(tmp_path, recording):
    async def story(driver):
        driver.device._pipeline = Incomplete(driver.device._pipeline)
        goal = GoalContext("1")
        told = await driver.capture(goal, image="a.png", depth="a_depth.png")
        fit = await driver.calibrate(GoalContext("2"), x=BOARD.x, y=BOARD.y)
        u, v = COLOUR.pixels(PLACE.seen(np.array([200, 260, 0.0])))
        deep = await driver.locate_point(GoalContext("3"), u=float(u), v=float(v))
        level = await driver.locate_point(GoalContext("4"), u=float(u), v=float(v), height=0)
        return told, fit, deep, level, await driver.status()

    driver = camera(tmp_path, recording=str(recording), answer_s=60)
    told, fit, deep, level, status = played(driver, story)

    assert (told["width"], told["height"]) == (640, 360)
    assert fit["rms"] < 0.3
    assert [fit[axis] for axis in "xyz"] == pytest.approx(PLACE.place, abs=1)
    assert (level["x"], level["y"]) == pytest.approx((200, 260), abs=0.4)
    away = np.linalg.norm([deep["x"] - 200, deep["y"] - 260, deep["z"]])
    assert away < min(2.0, deep["uncertainty"])
    matched = 0.25 * 520**2 / (DEPTH.focal * BASELINE)  # a quarter of a pixel between the eyes
    assert deep["uncertainty"] > 2 * matched
    assert status == {"connected": True, "calibrated": True, "rms": round(fit["rms"], 3)}


@pytest.mark.slow
def test_where_it_is_outlives_its_server_and_holds_for_this_camera_only(tmp_path, recording):
    async def story(driver):
        if not driver.calibration:
            await driver.calibrate(GoalContext("1"), x=BOARD.x, y=BOARD.y)
        return driver.lens, await driver.status()

    config = {"recording": str(recording), "answer_s": 60}
    first, again = (played(camera(tmp_path, **config), story) for _ in range(2))

    assert first == again and again[1]["calibrated"]
    assert again[0] == "RealSense 0123"


@pytest.mark.parametrize(
    ("config", "words"),
    [
        ({}, "there is no RealSense camera: is it plugged in, into USB 3?"),
        ({"recording": "none.db3"}, "there is no recording"),
        ({"recording": __file__}, "cannot be started"),
    ],
)
def test_what_cannot_be_opened_is_said_why(tmp_path, config, words):
    with pytest.raises(OSError, match=words.replace("?", "[?]")):
        camera(tmp_path, **config).device.open()


@pytest.mark.parametrize(
    ("config", "words"),
    [
        ({"serial": "1", "recording": "a.db3"}, "has both `serial` and `recording`"),
        ({"camera": "cam.yaml"}, "config has no key camera; its keys are: serial, recording, size"),
        ({"size": [640]}, r"size is \[640\]"),
        ({"answer_s": 0}, "answer_s is 0; it must be a number above 0"),
    ],
)
def test_a_configuration_that_cannot_be_is_refused(tmp_path, config, words):
    with pytest.raises(ValueError, match=words):
        camera(tmp_path, **config)


@pytest.mark.parametrize(("number", "said"), [("2.1", "is USB 2.1"), ("3.2", ""), (None, "")])
def test_a_camera_in_a_slow_port_is_told_where_it_fails(number, said):
    device = rs.software_device()
    if number is not None:
        device.register_info(rs.camera_info.usb_type_descriptor, number)

    told = slow_port(device)

    assert said in told and bool(told) == bool(said)


SEVERAL = ("brown_conrady", "modified_brown_conrady", "inverse_brown_conrady")


@pytest.mark.parametrize("model", SEVERAL)
def test_a_lens_is_that_of_the_library_whatever_way_round_it_is_described(model):
    """Numbers of the size of a D455's."""
    lens = known(COLOUR, model, (-0.055, 0.066, -0.0006, 0.0005, -0.021))

    pixels = np.array([[0.0, 0], [639, 359], [320, 180], [100, 300], [600, 20]])
    rays = np.array([rs.rs2_deproject_pixel_to_point(lens, list(one), 1.0) for one in pixels])

    assert np.abs(eye_of(lens).pixels(rays) - pixels).max() < 0.05


def test_a_lens_that_brown_s_numbers_do_not_describe_is_refused():
    lens = known(COLOUR, "kannala_brandt4", (0.4, -0.3, 0.2, 0.1, 0.0))

    with pytest.raises(OSError, match=r"the nearest is .* pixels off"):
        eye_of(lens)


def test_a_library_that_lacks_one_of_the_system_says_what_brings_it(tmp_path, monkeypatch):
    """As the wheel for Linux where libusb is not installed."""
    said = "libusb-1.0.so.0: cannot open shared object file"
    (tmp_path / "pyrealsense2.py").write_text(f"raise ImportError({said!r}, name=__name__)")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "pyrealsense2", raising=False)

    with pytest.raises(OSError, match=r"libusb.* add it with: apt-get install libusb"):
        RealSenseDevice(None, None, None, 1.0).open()
