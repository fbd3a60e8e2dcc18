"""Have all kernels ready before the first spectrum comes: loaded, or compiled on first use."""

import numpy as np

from .read import read_spectrum
from .reduce import reduce_spectrum


def warm_up() -> None:
    """Reduce a made-up spectrum that has what real ones have: noise, peaks alone and in pairs."""
    import scipy.special  # noqa: F401  # a self-absorbed line wants it, and this one has none

    wavelength = np.linspace(190.0, 950.0, 22_800)
    counts = 200 + np.random.default_rng(1).normal(0, 5, len(wavelength))
    for centre in (*np.arange(250.0, 800.0, 20.0), 250.3, 610.36, 670.78, 656.28, 766.49):
        counts += 4000 / (1 + ((wavelength - centre) / 0.08) ** 2)
    rows = (f"{x:.4f},{y:.1f}" for x, y in zip(wavelength, counts, strict=True))
    reduce_spectrum(read_spectrum("\n".join(("wavelength,intensity", *rows)).encode()))
