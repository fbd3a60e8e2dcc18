"""Prepare all kernels before the first spectrum: load them, or compile them on first use."""

import numpy as np

from .reduce import reduce_spectrum
from .spectrum.read import read_spectrum


def warm_up() -> None:
    """Reduce a synthetic spectrum with the features of real ones: noise, single and paired peaks."""
    import scipy.special  # noqa: F401  # a self-absorbed line wants it, and this one has none

    wavelength = np.linspace(190.0, 950.0, 22_800)
    counts = 200 + np.random.default_rng(1).normal(0, 5, len(wavelength))
    for centre in (*np.arange(250.0, 800.0, 20.0), 250.3, 610.36, 670.78, 656.28, 766.49):
        counts += 4000 / (1 + ((wavelength - centre) / 0.08) ** 2)
    rows = (f"{x:.4f},{y:.1f}" for x, y in zip(wavelength, counts, strict=True))
    reduce_spectrum(read_spectrum("\n".join(("wavelength,intensity", *rows)).encode()))
