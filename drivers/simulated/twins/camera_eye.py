"""Draw what an eye sees of a scene from a pose: planes in perspective, near over far."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ...cameras.vision.intrinsics import Intrinsics
from ...cameras.vision.pose import Pose
from .board import print_onto
from .camera_scene import (
    CORE_STEP_MM,
    PLATE_MM,
    PLATE_STEP_MM,
    Scene,
    Stone,
    core_texture,
    plate_texture,
    stone_texture,
)

if TYPE_CHECKING:
    import numpy as np

SHADE = {"top": 1.0, "front": 0.62, "back": 0.55, "left": 0.75, "right": 0.7}
NOISE = 1.8  # grey levels


def see(scene: Scene, pose: Pose, eye: Intrinsics) -> "np.ndarray":
    """The picture of one eye, without noise: (height, width, 3), blue first."""
    import numpy as np

    picture = np.zeros((eye.height, eye.width, 3), np.uint8)
    left, front, right, back = PLATE_MM
    _lay(picture, plate_texture(), (left, front, right, back), PLATE_STEP_MM, pose, eye)
    core = core_texture(scene.core)
    height, width = core.shape[0] * CORE_STEP_MM, core.shape[1] * CORE_STEP_MM
    _lay(picture, core, (0.0, 0.0, width, height), CORE_STEP_MM, pose, eye)
    if scene.board is not None:
        print_onto(picture, scene.board, _bench_to_pixel(pose, eye))
    for stone in sorted(scene.stones, key=lambda stone: -_distance(stone, pose)):
        _stand(picture, stone, pose, eye)
    return picture


def noisy(picture: "np.ndarray", random: "np.random.Generator") -> "np.ndarray":
    """The picture as the chip gives it."""
    import numpy as np

    noise = random.normal(0, NOISE, picture.shape).astype(np.float32)
    return np.clip(picture + noise, 0, 255).astype(np.uint8)


def _bench_to_pixel(pose: Pose, eye: Intrinsics) -> "np.ndarray":
    import numpy as np

    across, away, shift = pose.turn[:, 0], pose.turn[:, 1], -pose.turn @ pose.place_mm
    return eye.matrix @ np.stack([across, away, shift], axis=1)


def _lay(
    picture: "np.ndarray",
    texture: "np.ndarray",
    area: tuple[float, float, float, float],
    step: float,
    pose: Pose,
    eye: Intrinsics,
) -> None:
    """Put a texture of the bench, z = 0, into the picture."""
    import cv2
    import numpy as np

    left, front = area[:2]
    to_bench = np.array([[step, 0, left + step / 2], [0, step, front + step / 2], [0, 0, 1]])
    cv2.warpPerspective(
        texture,
        _bench_to_pixel(pose, eye) @ to_bench,
        (eye.width, eye.height),
        dst=picture,
        flags=cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_TRANSPARENT,
    )


def _stand(picture: "np.ndarray", stone: Stone, pose: Pose, eye: Intrinsics) -> None:
    """Draw the faces of a stone that look towards the eye, the top last."""
    import cv2
    import numpy as np

    for name, corners, size, seed in _faces(stone, pose):
        texture = (stone_texture(*size, seed) * SHADE[name]).astype(np.uint8)
        height, width = texture.shape[:2]
        edges = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32) - 0.5
        seen = pose.project(corners, eye).astype(np.float32)
        cv2.warpPerspective(
            texture,
            cv2.getPerspectiveTransform(edges, seen),
            (eye.width, eye.height),
            dst=picture,
            flags=cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_TRANSPARENT,
        )


def _faces(
    stone: Stone, pose: Pose
) -> Iterator[tuple[str, "np.ndarray", tuple[float, float], int]]:
    import numpy as np

    x, y, h = stone.x, stone.y, stone.height
    right, back = x + stone.width, y + stone.length
    eye_x, eye_y, _ = pose.place_mm
    a, b, c, d = (x, y), (right, y), (right, back), (x, back)
    sides = [
        ("front", a, b, eye_y < y),
        ("right", b, c, eye_x > right),
        ("back", c, d, eye_y > back),
        ("left", d, a, eye_x < x),
    ]
    for seed, (name, start, end, seen) in enumerate(sides):
        if seen:
            length = float(np.hypot(end[0] - start[0], end[1] - start[1]))
            corners = np.array([[*start, 0], [*end, 0], [*end, h], [*start, h]], float)
            yield name, corners, (length, h), seed
    top = np.array([[*corner, h] for corner in (a, b, c, d)], float)
    yield "top", top, (stone.width, stone.length), 4 + round(x + 7 * y)


def _distance(stone: Stone, pose: Pose) -> float:
    import numpy as np

    middle = np.array([stone.x + stone.width / 2, stone.y + stone.length / 2, stone.height])
    return float(np.linalg.norm(middle - pose.place_mm))
