"""Read a camera from a file: labrun's own YAML, OpenCV's FileStorage, ROS, or a ZED's .conf."""

from pathlib import Path
from typing import Any

from .camera import Camera, CameraFault

LARGEST = 4_000_000  # bytes; a camera file is about a page
KINDS = (
    "a camera file is what `labrun calibrate-camera` writes, OpenCV's YAML, XML or JSON, ROS's "
    "camera_info, or a ZED's .conf"
)


def read_cameras(path: Path) -> tuple[Camera, ...]:
    """The camera in a file, once for each picture size that it has; raises CameraFault."""
    text = _text(path)
    try:
        return _read(path, text)
    except CameraFault as fault:
        raise CameraFault(f"{path}: {fault}") from fault
    except KeyError as fault:
        raise CameraFault(f"{path} has no {fault.args[0]}; {KINDS}") from fault
    except (TypeError, ValueError, AttributeError) as fault:
        raise CameraFault(f"{path} does not describe a camera ({fault}); {KINDS}") from fault


def write_camera(path: Path, camera: Camera, words: str = "") -> None:
    """Write labrun's own YAML, with `words` at the top as a comment; raises OSError."""
    import yaml

    head = "".join(f"# {line}\n" for line in words.splitlines())
    body = yaml.safe_dump(camera.to_dict(), sort_keys=False, default_flow_style=None, width=100)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(head + body, encoding="utf-8", newline="\n")


def _text(path: Path) -> str:
    try:
        if path.stat().st_size > LARGEST:
            raise CameraFault(f"{path} is too large for a camera file; {KINDS}")
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise CameraFault(f"{path} is not text; {KINDS}") from None
    except OSError as fault:
        raise CameraFault(f"{path} cannot be read: {fault.strerror or fault}") from fault


def _read(path: Path, text: str) -> tuple[Camera, ...]:
    from .opencv_file import is_opencv, opencv_camera
    from .zed_conf import is_zed, zed_cameras

    if is_zed(text):
        return zed_cameras(text)
    if is_opencv(text):
        return (opencv_camera(text),)
    return (Camera.from_dict(_plain(text)),)


def _plain(text: str) -> dict[str, Any]:
    import yaml

    try:
        told = yaml.safe_load(text)
    except yaml.YAMLError as fault:
        mark = getattr(fault, "problem_mark", None)
        place = f" in line {mark.line + 1}" if mark is not None else ""
        raise CameraFault(f"this is not YAML{place}; {KINDS}") from fault
    if not isinstance(told, dict):
        raise CameraFault(f"this does not describe a camera; {KINDS}")
    return _of_ros(told) if "camera_matrix" in told else told


def _of_ros(told: dict[str, Any]) -> dict[str, Any]:
    """ROS's camera_info, whose matrices are `{rows, cols, data}`."""
    import numpy as np

    return {
        "width": told["image_width"],
        "height": told["image_height"],
        "matrix": np.reshape(told["camera_matrix"]["data"], (3, 3)).tolist(),
        "distortion": told["distortion_coefficients"]["data"],
    }
