"""The maker's calibration of a ZED stereo camera: `SN12345678.conf`, one section per lens and size.

As Stereolabs' own zed-open-capture reads it; its translation has the opposite sign to OpenCV's.
"""

from configparser import ConfigParser, Error, SectionProxy

from .camera import Camera, CameraFault
from .intrinsics import Intrinsics

SIZES = {"2k": (2208, 1242), "fhd": (1920, 1080), "hd": (1280, 720), "vga": (672, 376)}
TURNED = ("rx", "cv", "rz")
NEEDED = ("fx", "fy", "cx", "cy", "k1", "k2")


def is_zed(text: str) -> bool:
    """Whether it is such a file."""
    return "[stereo]" in text.lower() and "[left_cam_" in text.lower()


def zed_cameras(text: str) -> tuple[Camera, ...]:
    """A camera for each picture size in the file; raises CameraFault."""
    parser = ConfigParser(strict=False)
    try:
        parser.read_string(text)
        sections = {name.lower(): parser[name] for name in parser.sections()}
        found = [
            _camera(sections, name, size)
            for name, size in SIZES.items()
            if f"left_cam_{name}" in sections and f"right_cam_{name}" in sections
        ]
    except Error as fault:
        raise CameraFault(f"this is not a ZED .conf: {fault.message}") from fault
    if not found:
        raise CameraFault("this ZED .conf has no pair of lenses")
    return tuple(found)


def _camera(sections: dict[str, SectionProxy], name: str, size: tuple[int, int]) -> Camera:
    import cv2
    import numpy as np

    stereo = sections["stereo"]
    baseline = _number(stereo, "baseline")
    if baseline <= 0:
        raise CameraFault(f"[STEREO] Baseline is {baseline:g} mm")
    shift = -np.array(
        [baseline, _number(stereo, f"ty_{name}", 0), _number(stereo, f"tz_{name}", 0)]
    )
    turn = cv2.Rodrigues(np.array([_number(stereo, f"{axis}_{name}", 0) for axis in TURNED]))[0]
    left, right = (_eye(sections[f"{side}_cam_{name}"], size) for side in ("left", "right"))
    return Camera(left, right, turn, shift)


def _eye(section: SectionProxy, size: tuple[int, int]) -> Intrinsics:
    import numpy as np

    fx, fy, cx, cy, *_ = (_number(section, key) for key in NEEDED)
    if min(fx, fy) <= 0:
        raise CameraFault(f"[{section.name}] fx and fy must be above 0")
    distortion = [_number(section, key, 0) for key in ("k1", "k2", "p1", "p2", "k3")]
    return Intrinsics(*size, np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]), np.array(distortion))


def _number(section: SectionProxy, key: str, otherwise: float | None = None) -> float:
    text = section.get(key)
    if text is None:
        if otherwise is None:
            raise CameraFault(f"[{section.name}] has no {key}")
        return otherwise
    try:
        return float(text)
    except ValueError:
        raise CameraFault(f"[{section.name}] {key} is {text!r}, not a number") from None
