"""Photographs of a bench whose truth is known, by a projection of their own.

Nothing here uses labrun or OpenCV: what measures cameras is measured by these pictures. Lengths
are mm; bench z is up; a camera sees (right, down, ahead); pixels are counted from the middle of
the first one.
"""

from dataclasses import dataclass

import numpy as np

BLACK, WHITE, BENCH = 30.0, 225.0, 120.0
RIM = 0.7  # of a square, white, around the outermost squares
FINE = 3  # places across a pixel


@dataclass(frozen=True)
class Lens:
    """f, the middle, and Brown's distortion k1 k2 p1 p2 k3, for pictures of one size."""

    width: int = 1280
    height: int = 720
    focal: float = 1065.0
    middle: tuple[float, float] = (639.5, 359.5)
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)

    def matrix(self) -> np.ndarray:
        u, v = self.middle
        return np.array([[self.focal, 0, u], [0, self.focal, v], [0, 0, 1.0]])

    def distorted(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where (x, y, 1) meets the chip, in focal lengths."""
        k1, k2, p1, p2, k3 = self.distortion
        r2 = x * x + y * y
        radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
        return (
            x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
        )

    def pixels(self, seen: np.ndarray) -> np.ndarray:
        """Pixels of points before the camera, shape (..., 3) to (..., 2)."""
        x, y = self.distorted(seen[..., 0] / seen[..., 2], seen[..., 1] / seen[..., 2])
        return np.stack([x * self.focal + self.middle[0], y * self.focal + self.middle[1]], -1)

    def rays(self, pixels: np.ndarray) -> np.ndarray:
        """(x, y, 1) of pixels: the distortion undone by Newton's rule with a numeric slope."""
        wanted = (pixels - self.middle) / self.focal
        x, y = wanted[..., 0].copy(), wanted[..., 1].copy()
        if any(self.distortion):
            step = 1e-6
            for _ in range(6):
                a, b = self.distorted(x, y)
                if max(np.abs(wanted[..., 0] - a).max(), np.abs(wanted[..., 1] - b).max()) < 1e-13:
                    break
                ax, bx = self.distorted(x + step, y)
                ay, by = self.distorted(x, y + step)
                j11, j12, j21, j22 = (ax - a), (ay - a), (bx - b), (by - b)
                e, f = (wanted[..., 0] - a) * step, (wanted[..., 1] - b) * step
                det = j11 * j22 - j12 * j21
                x, y = x + (e * j22 - f * j12) / det, y + (f * j11 - e * j21) / det
        return np.stack([x, y, np.ones_like(x)], -1)


@dataclass(frozen=True)
class Stand:
    """How a camera stands: `turn` takes bench directions to the camera's, `place` is on the bench."""

    turn: np.ndarray
    place: np.ndarray

    def seen(self, points: np.ndarray) -> np.ndarray:
        return (points - self.place) @ self.turn.T

    def beside(self, baseline: float) -> "Stand":
        """An eye so far to the right."""
        return Stand(self.turn, self.place + baseline * self.turn[0])


def stand(
    target: np.ndarray, away: float, tilt: float, azimuth: float = 0.0, roll: float = 0.0
) -> Stand:
    """Looking at a bench point from `away`, `tilt` degrees from straight above.

    At azimuth 0 the camera looks towards bench y; bench x is to the right unless it rolls.
    """
    t, a, r = np.radians([tilt, azimuth, roll])
    ahead = np.array([np.sin(a) * np.sin(t), np.cos(a) * np.sin(t), -np.cos(t)])
    right = np.array([np.cos(a), -np.sin(a), 0.0])
    down = np.cross(ahead, right)
    cos, sin = np.cos(r), np.sin(r)
    turn = np.array([cos * right + sin * down, cos * down - sin * right, ahead])
    return Stand(turn, np.asarray(target, float) - away * ahead)


@dataclass(frozen=True)
class Chessboard:
    """Inner corners and where the first one lies; the square outside it is black."""

    columns: int = 9
    rows: int = 6
    square: float = 25.0
    x: float = 100.0
    y: float = 300.0
    angle: float = 0.0
    height: float = 0.0

    def corners(self) -> np.ndarray:
        """Shape (rows, columns, 3)."""
        i, j = np.meshgrid(np.arange(self.columns), np.arange(self.rows))
        turn = np.exp(1j * np.radians(self.angle))
        place = complex(self.x, self.y) + turn * (i + 1j * j) * self.square
        return np.stack([place.real, place.imag, np.full(place.shape, self.height)], -1)

    def middle(self) -> np.ndarray:
        return self.corners().mean(axis=(0, 1))

    def shade(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Grey at bench places."""
        own = (x - self.x + 1j * (y - self.y)) * np.exp(-1j * np.radians(self.angle)) / self.square
        i, j = own.real, own.imag
        inside = (i >= -1) & (i < self.columns) & (j >= -1) & (j < self.rows)
        black = inside & ((np.floor(i) + np.floor(j)) % 2 == 0)
        plate = (i >= -1 - RIM) & (i < self.columns + RIM) & (j >= -1 - RIM) & (j < self.rows + RIM)
        return np.where(black, BLACK, np.where(plate, WHITE, BENCH))


def photograph(
    lens: Lens, at: Stand, board: Chessboard, random: np.random.Generator | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """The picture, 8 bit grey, every pixel an average of what it sees; and the depth map, mm."""
    picture, depth = np.empty((lens.height, lens.width)), np.empty((lens.height, lens.width))
    fine = (np.arange(FINE) + 0.5) / FINE - 0.5
    u = (np.arange(lens.width)[:, None] + fine).ravel()
    for top in range(0, lens.height, 90):
        rows = np.arange(top, min(top + 90, lens.height))
        v = (rows[:, None] + fine).ravel()
        rays = lens.rays(np.stack(np.meshgrid(u, v), -1))
        bench = rays @ at.turn
        far = (board.height - at.place[2]) / bench[..., 2]  # a plate fills what it sees
        x, y = at.place[0] + bench[..., 0] * far, at.place[1] + bench[..., 1] * far
        shade = np.where(far > 0, board.shade(x, y), BENCH)
        blocks = (len(rows), FINE, lens.width, FINE)
        picture[rows] = shade.reshape(blocks).mean(axis=(1, 3))
        depth[rows] = np.where(far > 0, far, np.nan)[FINE // 2 :: FINE, FINE // 2 :: FINE]
    if random is not None:
        picture += random.normal(0, 2.0, picture.shape)
    return np.clip(np.round(picture), 0, 255).astype(np.uint8), depth
