"""A pair of simulated eyes: where they are, what lies before them, and the pictures they take."""

from functools import cached_property
from typing import TYPE_CHECKING, Any

from ...cameras.vision.board import Board
from ...cameras.vision.intrinsics import Intrinsics
from ...cameras.vision.rig import Rig
from ...driver import check_keys
from ...world import World
from .camera_scene import Scene, Stone
from .faults import chance

if TYPE_CHECKING:
    from ...cameras.vision.pose import Pose
    from ...cameras.vision.view import StereoView

WIDTH, HEIGHT, FOCAL_PX, BASELINE_MM = 1280, 720, 1065.0, 60.0
CARRIED = {"x": 60.0, "y": 40.0, "z": 400.0, "tilt": 30.0}
STANDING = {"x": 200.0, "y": 70.0, "z": 500.0, "tilt": 30.0}
BOARD = {"columns": 9, "rows": 6, "square": 25.0, "x": 100.0, "y": 300.0}


class Eyes:
    """Read a twin's configuration; raises ValueError if it is invalid."""

    def __init__(self, config: dict[str, Any], world: World, seed: int) -> None:
        self.world, self.seed = world, seed
        self.gantry = config.get("gantry")
        self.mount = _filled("place", config.get("place"), CARRIED if self.gantry else STANDING)
        self.scene = Scene(
            _board(config.get("board", {})),
            tuple(Stone(*map(float, stone)) for stone in config.get("stones") or []),
            int(config.get("core", 3)),
        )

    @cached_property
    def rig(self) -> Rig:
        """The eyes themselves: a lab that is checked, as for each report, needs none, and no numpy."""
        return Rig(Intrinsics.ideal(WIDTH, HEIGHT, FOCAL_PX), BASELINE_MM)

    def carriage_mm(self) -> list[float]:
        """Where the gantry truly holds the eyes; zero for those that stand still."""
        found = self.world.look(str(self.gantry)) if self.gantry else None
        return [float((found or {}).get(axis, 0.0)) for axis in "xyz"]

    def pose(self) -> "Pose":
        """Where the left eye truly is, and how it looks."""
        from ...cameras.vision.pose import Pose

        carried = zip("xyz", self.carriage_mm(), strict=True)
        x, y, z = (self.mount[axis] + moved for axis, moved in carried)
        return Pose.looking((x, y, z), self.mount["tilt"])

    def look(self, goal_id: str, trouble: str | None) -> "StereoView":
        """What both eyes see now, spoilt by a trouble; the noise is the goal's own."""
        import numpy as np

        from ...cameras.vision.view import StereoView
        from .camera_eye import noisy, see
        from .camera_trouble import spoil

        pose, eye = self.pose(), self.rig.eye
        other = pose.beside(self.rig.baseline_mm)
        pair = see(self.scene, pose, eye), see(self.scene, other, eye)
        if trouble is not None:
            pair = spoil(pair, trouble, self._middle_of_board(pose))
        random = np.random.default_rng(int(chance(self.seed, "noise", goal_id) * 2**53))
        return StereoView(noisy(pair[0], random), noisy(pair[1], random), self.rig)

    def _middle_of_board(self, pose: "Pose") -> tuple[float, float]:
        """The pixel where the board is, or the middle of the picture where there is none."""
        if self.scene.board is None:
            return (WIDTH - 1) / 2, (HEIGHT - 1) / 2
        u, v = pose.project(self.scene.board.corners_mm().mean(axis=(0, 1)), self.rig.eye)
        return float(u), float(v)


def _board(said: dict[str, Any] | None) -> Board | None:
    if said is None:
        return None
    full = _filled("board", said, BOARD)
    size = int(full["columns"]), int(full["rows"])
    return Board(*size, full["square"], full["x"], full["y"])


def _filled(name: str, said: dict[str, Any] | None, usual: dict[str, float]) -> dict[str, float]:
    check_keys(usual, said or {}, name)
    return {key: float((said or {}).get(key, value)) for key, value in usual.items()}
