"""How much of its light a line keeps when it absorbs itself: the curve of growth of a Lorentzian.

In a uniform plasma in local equilibrium, area = thin area * f(tau), f = e^-x (I0(x) + I1(x)) with
x = tau / 2 and tau the optical depth in the middle of the line (Ladenburg and Reiche, Ann. Phys.
347, 181 (1913)). By Kirchhoff's law tau follows from the thin area, Planck's radiance and the
line's own width, up to one constant for the whole spectrum.
"""

from functools import cache
from importlib.resources import files
from io import BytesIO

import numpy as np

from ..spectrum.spectrum import FloatArray

HC_BY_K_NM_K = 1.438776877e7  # h c / k
PEAK_OF_LORENTZIAN = 2.0 / np.pi  # times 1 / full width


@cache
def growth_table() -> tuple[FloatArray, FloatArray, FloatArray]:
    """ln tau, ln f and d ln f / d ln tau, close enough for straight lines between them.

    A file has them, so that no reduction waits for the import of scipy.
    """
    packed = files("labrun.reduction.data").joinpath("growth.npz").read_bytes()
    with np.load(BytesIO(packed), allow_pickle=False) as table:
        return table["log_tau"], table["log_f"], table["slope"]


def log_kept(log_tau: FloatArray) -> FloatArray:
    """ln f, from 0 downwards, of ln tau; any shape."""
    grid, log_f, _ = growth_table()
    return np.interp(log_tau, grid, log_f)


def growing(kept: FloatArray) -> FloatArray:
    """d ln(area) / d ln(thin area), from 1 of a thin line to 1/2 of a thick one, where a line keeps a part
    of its light; any shape."""
    _, log_f, slope = growth_table()
    return 1.0 + np.interp(-np.log(kept), -log_f, slope)


def log_radiance(wavelength_nm: FloatArray, temperature_k: float | FloatArray) -> FloatArray:
    """ln of Planck's radiance per nm, arbitrary unit (the same at all temperatures)."""
    x = HC_BY_K_NM_K / (wavelength_nm * temperature_k)
    return -5.0 * np.log(wavelength_nm / 500.0) - np.log(np.expm1(x))


def log_depth_of_unit(
    wavelength_nm: FloatArray, width_nm: FloatArray, temperature_k: float | FloatArray
) -> FloatArray:
    """ln tau that a line of thin area 1 would have if the constant of the spectrum were 1."""
    peak = np.log(PEAK_OF_LORENTZIAN / np.maximum(width_nm, 1e-4))
    return peak - log_radiance(wavelength_nm, temperature_k)
