"""A RealSense camera, through its maker's library: colour, and depth that lies on it pixel by pixel.

Configuration: `serial` (where several are plugged in), or `recording` (a file of the RealSense Viewer,
played again and again) in place of a camera; `size` ([width, height] of the colour picture), `answer_s`
(how long a picture may take, 5 s). The lens is the one that the camera itself knows of.
"""

# pyrealsense2 is only there with the extra, and brings no types.
# pyright: reportMissingImports=false, reportAttributeAccessIssue=false

import time
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from ...system.extras import not_installed
from ..driver import Place
from .folder import Shot
from .still_camera import ANSWER_S, LibrarySource, StillCamera, above_zero, picture_size

if TYPE_CHECKING:
    import numpy as np

    from .vision.intrinsics import Intrinsics

OPTIONS = ("serial", "recording", "size", "answer_s")
WARM, STALE = 30, 1
"""Pictures until the exposure has found its value; old ones that the library keeps."""
MM = 1000.0
GRID = 24
CLOSE_PX = 0.1


class RealSense(StillCamera):
    """Implements depth_camera@1."""

    extra: ClassVar[str | None] = "realsense"

    def __init__(self, place: Place) -> None:
        config = place.config
        serial = None if config.get("serial") is None else str(config["serial"])
        recording = None if config.get("recording") is None else Path(str(config["recording"]))
        if serial is not None and recording is not None:
            raise ValueError("config has both `serial` and `recording`: give one of them")
        answer_s = above_zero(config.get("answer_s", ANSWER_S), "answer_s")
        self.device = RealSenseDevice(serial, recording, picture_size(config), answer_s)
        super().__init__(place, self.device, OPTIONS)

    @property
    def lens(self) -> str:
        return f"RealSense {self.device.serial}"


class RealSenseDevice(LibrarySource):
    """Takes pictures of a camera, or of a recording in its place."""

    def __init__(
        self, serial: str | None, recording: Path | None, size: tuple[int, int] | None,
        answer_s: float,
    ) -> None:  # fmt: skip
        self.serial, self.recording, self.size, self.answer_s = serial, recording, size, answer_s
        self._onto_colour: Any = None
        self._reach_mm: float | None = None
        self._port = ""

    @property
    def name(self) -> str:
        """What gives the pictures, in messages."""
        if self.recording is not None:
            return f"the recording {self.recording}"
        return f"RealSense {self.serial}" if self.serial else "the RealSense camera"

    def open(self) -> None:
        """Start it; raises OSError with the reason."""
        try:
            import pyrealsense2 as rs
        except ImportError as fault:  # its wheel for Linux does not bring libusb
            raise OSError(not_installed(fault, "realsense") or str(fault)) from fault

        config = rs.config()
        if self.recording is None:
            self._choose(config, rs)
        elif not self.recording.is_file():
            raise OSError(f"there is no recording {self.recording.absolute()}")
        else:
            config.enable_device_from_file(str(self.recording), True)
        pipeline = rs.pipeline()
        try:
            profile = pipeline.start(config)
        except RuntimeError as fault:
            raise OSError(f"{self.name} cannot be started: {fault}{self._port}") from fault
        self._pipeline, self._onto_colour = pipeline, rs.align(rs.stream.color)
        try:
            self._know(profile, rs)
            self._warm_up()
        except (RuntimeError, OSError) as fault:
            self.close()
            raise OSError(f"{self.name}: {fault}") from fault

    def _choose(self, config: Any, rs: Any) -> None:
        number = rs.camera_info.serial_number
        there = {device.get_info(number): device for device in rs.context().query_devices()}
        if not there:
            raise OSError("there is no RealSense camera: is it plugged in, into USB 3?")
        if self.serial is None and len(there) > 1:
            raise OSError(
                f"there are several RealSense cameras: give `serial`, one of {_listed(there)}"
            )
        if self.serial is not None and self.serial not in there:
            raise OSError(f"there is no RealSense {self.serial}; there is {_listed(there)}")
        serial = self.serial or next(iter(there))
        self._port = slow_port(there[serial])
        config.enable_device(serial)
        config.enable_stream(rs.stream.depth, rs.format.z16)
        if self.size is None:
            config.enable_stream(rs.stream.color, rs.format.bgr8)
        else:
            config.enable_stream(rs.stream.color, *self.size, rs.format.bgr8)

    def _know(self, profile: Any, rs: Any) -> None:
        """Which camera it is, and how well it sees depth."""
        kinds = {stream.stream_type(): stream for stream in profile.get_streams()}
        for kind, word in ((rs.stream.color, "colour"), (rs.stream.depth, "depth")):
            if kind not in kinds:
                raise OSError(f"it has no {word}")
        device = profile.get_device()
        self.serial = str(device.get_info(rs.camera_info.serial_number))
        sensor, baseline = device.first_depth_sensor(), rs.option.stereo_baseline
        if sensor.supports(baseline):  # of two eyes; one that sends light has none
            focal = kinds[rs.stream.depth].as_video_stream_profile().intrinsics.fx
            self._reach_mm = focal * sensor.get_option(baseline)

    def _warm_up(self) -> None:
        for _ in range(WARM if self.recording is None else 0):
            self._frames()

    def _frames(self) -> Any:
        return self._pipeline.wait_for_frames(round(MM * self.answer_s))

    def _both(self) -> Any:
        """The next frames with colour and depth: after a start, and over a busy port, one may be missing."""
        until = time.monotonic() + self.answer_s
        while time.monotonic() < until:
            frames = self._frames()
            if frames.get_color_frame() and frames.get_depth_frame():
                return frames
        words = f"no picture came together with its depth within {self.answer_s:g} s"
        raise RuntimeError(f"{words}{self._port}")

    def _read(self) -> Shot:
        import numpy as np

        for _ in range(STALE):
            self._frames()
        frames = self._onto_colour.process(self._both())
        colour, depth = frames.get_color_frame(), frames.get_depth_frame()
        steps = np.asanyarray(depth.get_data()).astype(np.float32)
        far_mm = np.where(steps > 0, steps * np.float32(MM * depth.get_units()), np.nan)
        lens = eye_of(colour.profile.as_video_stream_profile().intrinsics)
        return Shot(_blue_first(colour), far_mm, eye=lens, reach_mm=self._reach_mm)


def eye_of(known: Any) -> "Intrinsics":
    """A lens as OpenCV describes it, from RealSense's `intrinsics`; raises OSError if there is none like it.

    Most colour lenses of RealSense are described the other way round (inverse Brown-Conrady: from the
    picture to the ray), so Brown's five numbers are fitted to what the library itself makes of pixels.
    """
    import numpy as np
    import pyrealsense2 as rs

    from .vision.intrinsics import Intrinsics

    matrix = np.array([[known.fx, 0, known.ppx], [0, known.fy, known.ppy], [0, 0, 1.0]])
    if not any(known.coeffs):
        return Intrinsics(known.width, known.height, matrix, np.zeros(5))
    if known.model == rs.distortion.brown_conrady:
        return Intrinsics(known.width, known.height, matrix, np.array(known.coeffs, float))
    u, v = np.meshgrid(
        np.linspace(0, known.width - 1, GRID), np.linspace(0, known.height - 1, GRID)
    )
    pixels = np.stack([u.ravel(), v.ravel()], axis=1)
    rays = np.array([rs.rs2_deproject_pixel_to_point(known, list(one), 1.0) for one in pixels])
    eye = Intrinsics(known.width, known.height, matrix, _brown(rays, pixels, matrix))
    off = float(np.abs(eye.pixels(rays) - pixels).max())
    if not off < CLOSE_PX:
        raise OSError(
            f"its lens ({known.model}) is not one that is known here: the nearest is {off:.1f} pixels off"
        )
    return eye


def _brown(rays: "np.ndarray", pixels: "np.ndarray", matrix: "np.ndarray") -> "np.ndarray":
    """k1 k2 p1 p2 k3 that take rays to pixels, by least squares: the model is linear in them."""
    import numpy as np

    x, y = rays[:, 0], rays[:, 1]
    r2 = x * x + y * y
    seen = (pixels - matrix[:2, 2]) / np.diag(matrix)[:2]
    across = np.stack([x * r2, x * r2**2, 2 * x * y, r2 + 2 * x * x, x * r2**3], axis=1)
    along = np.stack([y * r2, y * r2**2, r2 + 2 * y * y, 2 * x * y, y * r2**3], axis=1)
    slopes, off = np.concatenate([across, along]), (seen - rays[:, :2]).T.ravel()
    return np.linalg.lstsq(slopes, off, rcond=None)[0]


def _blue_first(colour: Any) -> "np.ndarray":
    """A colour frame as OpenCV holds it; raises OSError for one in another format."""
    import numpy as np

    picture = np.asanyarray(colour.get_data())
    kind = colour.profile.format().name
    if kind not in ("bgr8", "rgb8"):
        raise OSError(f"its pictures are in the format {kind}; record them as BGR8 or RGB8")
    return np.ascontiguousarray(picture if kind == "bgr8" else picture[..., ::-1])


def slow_port(device: Any) -> str:
    """What to add where a camera fails that is not in a port of USB 3; else nothing."""
    import pyrealsense2 as rs

    kind = rs.camera_info.usb_type_descriptor
    number = device.get_info(kind) if device.supports(kind) else "3"
    if number.startswith("3"):
        return ""
    return f"; its port or cable is USB {number}, for small pictures: use USB 3, or give a smaller `size`"


def _listed(serials: Iterable[str]) -> str:
    return ", ".join(sorted(serials))
