"""A simulated pegmatite core: grains of six minerals, laid out for ever by a seed.

Each grain grows from a nucleus, longer in one direction than in the others; a place belongs to
the grain that reaches it first. Nuclei stand on a jittered lattice, so that a place has to ask
only the 25 nearest cells and a core of any size costs the same.
"""

import numpy as np

from .minerals import ELEMENTS, MINERALS, atom_fractions

WIDTH_MM = 48.0
HEIGHT_MM = 120.0
CELL_MM = 1.15
REACH = 2  # cells to either side that may hold the grain of a place
SPOT_MM = 0.04  # radius of the laser's crater


class Core:
    """The core of one seed, on the bench at x 0..48 and y 0..120 mm, its surface near z = 0."""

    def __init__(self, seed: int = 3) -> None:
        random = np.random.default_rng([seed, 0xC02E])
        self.columns = int(WIDTH_MM / CELL_MM) + 2 * REACH + 2
        self.rows = int(HEIGHT_MM / CELL_MM) + 2 * REACH + 2
        draw = random.random((8, self.rows, self.columns))
        shares = np.cumsum([mineral.share for mineral in MINERALS])
        self.kind = np.searchsorted(shares / shares[-1], draw[0], side="right")
        lattice_y, lattice_x = np.mgrid[: self.rows, : self.columns]
        self.nucleus_x = (lattice_x - REACH + draw[1] * 0.9) * CELL_MM
        self.nucleus_y = (lattice_y - REACH + draw[2] * 0.9) * CELL_MM
        stretch = np.array([m.stretch for m in MINERALS])[self.kind] ** (0.5 + draw[3])
        size = np.array([m.size for m in MINERALS])[self.kind] * np.exp(0.5 * (draw[4] - 0.5))
        self.length, self.breadth = size * np.sqrt(stretch), size / np.sqrt(stretch)
        angle = np.pi * draw[5]
        self.cos, self.sin = np.cos(angle), np.sin(angle)
        self.richness = draw[6]  # of a grain in traces
        self.phase = draw[7] * 2 * np.pi
        self.fractions = np.array(
            [[atom_fractions(m.name).get(e, 0.0) for e in ELEMENTS] for m in MINERALS]
        )
        # What is more than a percent of the atoms is bound by the formula and hardly varies.
        self.spread = np.where(self.fractions > 0.01, 0.03, 0.35)

    @staticmethod
    def holds(x: float, y: float) -> bool:
        """Whether there is any core at that place of the bench."""
        return 0 <= x <= WIDTH_MM and 0 <= y <= HEIGHT_MM

    def grain_at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Indices of the grains that hold the places, shape of x; places are mm on the bench."""
        x, y = _wander(np.asarray(x, float), np.asarray(y, float))
        column = np.floor(x / CELL_MM).astype(int) + REACH
        row = np.floor(y / CELL_MM).astype(int) + REACH
        around = np.arange(-REACH, REACH + 1)
        rows = np.clip(row[..., None, None] + around[:, None], 0, self.rows - 1)
        columns = np.clip(column[..., None, None] + around, 0, self.columns - 1)
        near = (rows * self.columns + columns).reshape(*x.shape, -1)
        dx = x[..., None] - self.nucleus_x.ravel()[near]
        dy = y[..., None] - self.nucleus_y.ravel()[near]
        cos, sin = self.cos.ravel()[near], self.sin.ravel()[near]
        along = (dx * cos + dy * sin) / self.length.ravel()[near]
        across = (dy * cos - dx * sin) / self.breadth.ravel()[near]
        first = np.argmin(along**2 + across**2, axis=-1)
        return np.take_along_axis(near, first[..., None], axis=-1)[..., 0]

    def mineral_at(self, x: float, y: float) -> str:
        """Name of the mineral at a place."""
        return MINERALS[int(self.kind.ravel()[self.grain_at(np.array(x), np.array(y))])].name

    def composition_at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Shares of all atoms at the places, shape (..., elements)."""
        x, y = np.asarray(x, float), np.asarray(y, float)
        grain = self.grain_at(x, y)
        kind = self.kind.ravel()[grain]
        rich = 2 * self.richness.ravel()[grain] - 1
        zoning = np.sin(2.1 * x + 1.3 * y + self.phase.ravel()[grain])
        vary = np.exp(self.spread[kind] * (0.8 * rich + 0.4 * zoning)[..., None])
        atoms = self.fractions[kind] * vary
        return atoms / atoms.sum(axis=-1, keepdims=True)

    def height_at(self, x: float, y: float) -> float:
        """Height of the sawn surface over z = 0, mm: a few hundredths."""
        waves = np.sin(0.31 * x + 0.2 * y) + 0.6 * np.sin(1.7 * x - 2.3 * y) + 0.5 * np.sin(5.1 * y)
        return float(0.015 * waves)

    def composition_in_crater(self, x: float, y: float) -> np.ndarray:
        """Shares of all atoms that one shot ablates: at a grain's edge of both sides."""
        angle = np.linspace(0, 2 * np.pi, 6, endpoint=False)
        spot_x = x + SPOT_MM * np.concatenate([[0], 0.9 * np.cos(angle), 0.5 * np.cos(angle + 0.5)])
        spot_y = y + SPOT_MM * np.concatenate([[0], 0.9 * np.sin(angle), 0.5 * np.sin(angle + 0.5)])
        return self.composition_at(spot_x, spot_y).mean(axis=0)


def _wander(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Bend the plane a little, since no grain boundary in a rock is straight."""
    shift_x = 0.10 * np.sin(2.9 * y + 0.7 * x) + 0.05 * np.sin(7.3 * y - 3.1 * x + 1.0)
    shift_y = 0.10 * np.sin(2.5 * x - 0.9 * y + 2.0) + 0.05 * np.sin(6.7 * x + 4.3 * y)
    return x + shift_x, y + shift_y
