"""What lies on the simulated bench: a speckled plate with the core let into it, a board, stones."""

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from ...cameras.vision.board import Board

if TYPE_CHECKING:
    import numpy as np

PLATE_MM = (-400.0, -300.0, 1200.0, 1400.0)  # left, front, right, back
PLATE_STEP_MM = 0.8
CORE_STEP_MM = 0.25
STONE_STEP_MM = 0.5
COLOURS = {
    "spodumene": (196, 214, 190),
    "quartz": (205, 205, 208),
    "albite": (232, 234, 236),
    "muscovite": (150, 178, 186),
    "K-feldspar": (158, 176, 222),
    "lepidolite": (186, 130, 170),
}
"""As OpenCV orders them: blue, green, red."""


@dataclass(frozen=True, slots=True)
class Stone:
    """A box on the bench: its left front corner, its size and its height, all in mm."""

    x: float
    y: float
    width: float
    length: float
    height: float


@dataclass(frozen=True, slots=True)
class Scene:
    """All there is to see; the core's number is that of the analyser's core."""

    board: Board | None
    stones: tuple[Stone, ...]
    core: int


@lru_cache(maxsize=2)
def plate_texture(seed: int = 7) -> "np.ndarray":
    """The bench plate from above, front row first: speckles for the two eyes to agree on."""
    left, front, right, back = PLATE_MM
    return speckled((right - left, back - front), PLATE_STEP_MM, (112, 116, 118), 30, seed)


@lru_cache(maxsize=4)
def core_texture(core: int) -> "np.ndarray":
    """The sawn face of the core from above, front row first, each mineral in its colour."""
    import numpy as np

    from .core import HEIGHT_MM, WIDTH_MM, Core
    from .minerals import MINERALS

    rock = Core(core)
    y, x = np.mgrid[0:HEIGHT_MM:CORE_STEP_MM, 0:WIDTH_MM:CORE_STEP_MM] + CORE_STEP_MM / 2
    shades = np.array([COLOURS.get(m.name, (200, 200, 200)) for m in MINERALS], float)
    colour = shades[rock.kind.ravel()[rock.grain_at(x, y)]]
    grain = np.random.default_rng(core).normal(0, 9, (*colour.shape[:2], 1))
    return np.clip(colour + grain, 0, 255).astype(np.uint8)


@lru_cache(maxsize=32)
def stone_texture(width_mm: float, length_mm: float, seed: int) -> "np.ndarray":
    """One face of a stone, like granite."""
    return speckled((width_mm, length_mm), STONE_STEP_MM, (142, 152, 166), 42, seed)


def speckled(
    size_mm: tuple[float, float],
    step_mm: float,
    colour: tuple[int, int, int],
    contrast: float,
    seed: int,
) -> "np.ndarray":
    """Speckles of several sizes about a colour, the same for ever."""
    import cv2
    import numpy as np

    width, height = (max(4, round(size / step_mm)) for size in size_mm)
    random = np.random.default_rng(seed)
    grey = np.zeros((height, width), np.float32)
    for speck_mm, share in ((1.0, 0.7), (3.0, 0.5), (12.0, 0.4)):
        noise = random.standard_normal((height, width), dtype=np.float32)
        sigma = speck_mm / step_mm
        soft = cv2.GaussianBlur(noise, (0, 0), sigma)
        grey += share * soft / (soft.std() + 1e-6)
    return np.clip(grey[..., None] * contrast + colour, 0, 255).astype(np.uint8)
