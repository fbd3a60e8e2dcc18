"""A whole spectrum beside those of the standards: what a PLS model reads from it, and how unlike them it is.

A spectrum is its light above the background in bins of true wavelength, as parts of all such light.
Models are fitted by `latent.py`, and kept in a calibration file; to use one needs numpy alone.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..reduce import Reduction
from ..spectrum.spectrum import FloatArray

BINS = 1_000
ORDINARY = 0.99  # of samples like the standards are within the limits of Q and T2


@dataclass(frozen=True, slots=True)
class Pls:
    """What a PLS regression (Wold et al., Chemom. Intell. Lab. Syst. 58, 109 (2001)) of one element reads
    from binned spectra: offset + bins . coefficients, wt %. importance: VIP of each bin, of which those
    above 1 matter. As `packed` writes it, both of them."""

    components: int
    offset: float
    coefficients: str
    importance: str

    def read(self, bins: FloatArray) -> FloatArray:
        """wt % by the model, shape (...,) of spectra (..., m)."""
        return self.offset + bins @ unpacked(self.coefficients)


@dataclass(frozen=True, slots=True)
class Place:
    """Where a standard lies among the others: scores on the first two components, and T2 and Q by
    components that were found without it."""

    sample: str
    scores: tuple[float, float]
    t2: float
    q: float


@dataclass(frozen=True, slots=True)
class Likeness:
    """Principal components of the standards' spectra, (k, m), with the variance of each one's scores.

    A spectrum's T2 is how far out it lies along them, Q what they leave unexplained (sum of squares);
    t2_limit and q_limit hold `ORDINARY` of samples like the standards, by the standards that were
    left out one at a time. weight: of bins.
    """

    mean: str
    weight: str
    components: tuple[str, ...]
    variances: tuple[float, ...]
    explained: tuple[float, ...]
    t2_limit: float
    q_limit: float
    places: tuple[Place, ...]

    def far(self, bins: FloatArray) -> tuple[float, float]:
        """T2 and Q of one binned spectrum (m,), as parts of their limits."""
        x = (bins - unpacked(self.mean)) * unpacked(self.weight)
        axes = np.array([unpacked(one) for one in self.components])
        t2, q = distances(x[None, :], axes, np.array(self.variances))
        return float(t2[0] / self.t2_limit), float(q[0] / self.q_limit)

    def outside(self, bins: FloatArray) -> str | None:
        """A sentence on how a spectrum is unlike the standards'; None if it is like them."""
        t2, q = self.far(bins)
        if max(t2, q) <= 1:
            return None
        said = [
            f"{name} is {part:.1f} times its {100 * ORDINARY:.0f} % limit"
            for name, part in (("Q", q), ("T2", t2))
            if part > 1
        ]
        return f"it is unlike the calibration's standards ({', '.join(said)}); concentrations may be off"


def distances(
    x: FloatArray, axes: FloatArray, variances: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """T2 and Q of weighted spectra (n, m) from their mean: Hotelling's, and the residual sum of squares."""
    scores = x @ axes.T
    left = x - scores @ axes
    return (scores**2 / variances).sum(axis=1), (left**2).sum(axis=1)


def binned(reduction: Reduction, range_nm: tuple[float, float]) -> FloatArray:
    """The parts of a spectrum's net light in `BINS` equal bins of a range of true wavelengths, (m,).

    Bad channels have none.
    """
    profiles = reduction.profiles
    x = profiles.wavelength_nm - reduction.offsets.at(profiles.wavelength_nm)
    net = np.where(profiles.bad, 0.0, profiles.net)
    light = np.histogram(x, bins=BINS, range=range_nm, weights=net)[0]
    return light / max(float(np.abs(net).sum()), 1e-300)


def packed(values: FloatArray) -> str:
    """Numbers as a file keeps them, in one line."""
    return " ".join(f"{value:.6g}" for value in values.tolist())


@lru_cache(maxsize=256)
def unpacked(text: str) -> FloatArray:
    """The numbers that `packed` wrote."""
    return np.array(text.split(), dtype=np.float64)
