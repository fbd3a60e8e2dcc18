"""The rows of `peaks`: every fitted peak of a spectrum, and its line."""

import numpy as np

from ..peaks.faddeeva import faddeeva
from ..peaks.levenberg import ROOT_2, ROOT_2_PI
from ..reduce import Reduction
from ..spectrum.bad import BadChannels
from ..spectrum.kernel import kernel
from ..spectrum.spectrum import BoolArray, FloatArray
from .columns import BETWEEN_FLAGS, Cells
from .named import Names, names


def peak_rows(wavelength_nm: FloatArray, reduction: Reduction) -> Cells:
    """All peaks, ascending in their centres. wavelength_nm: of the spectrum, shape (m,)."""
    peaks, named = reduction.peaks, names(reduction)
    height = heights(peaks.area, peaks.sigma_nm, peaks.gamma_nm)
    x = reduction.profiles.wavelength_nm
    channel = np.searchsorted(x, peaks.centre_nm).clip(0, len(x) - 1)
    return {
        "center_nm": peaks.centre_nm,
        "area": peaks.area,
        "area_err": peaks.area_error,
        "sigma_nm": peaks.sigma_nm,
        "gamma_nm": peaks.gamma_nm,
        "fwhm_nm": peaks.fwhm_nm,
        "height": height,
        "snr": height / reduction.profiles.noise[channel],
        "chi2": peaks.chi2,
        "element": named.element,
        "stage": [stage or None for stage in named.stage.tolist()],
        "line_nm": named.line_nm,
        "flags": _flags(wavelength_nm, reduction, named),
    }


@kernel
def heights(area, sigma_nm, gamma_nm):
    """Counts at the tops of Voigt profiles: area Re w(i gamma / (sigma sqrt 2)) / (sigma sqrt 2pi).

    Three shapes (k,), sigma above 0.
    """
    top = np.empty(len(area))
    for k in range(len(area)):
        w = faddeeva(complex(0.0, gamma_nm[k] / (sigma_nm[k] * ROOT_2)))
        top[k] = area[k] * w.real / (sigma_nm[k] * ROOT_2_PI)
    return top


def _flags(wavelength_nm: FloatArray, reduction: Reduction, named: Names) -> list[str]:
    peaks, bad = reduction.peaks, reduction.bad
    lowest, highest = peaks.centre_nm - peaks.fwhm_nm, peaks.centre_nm + peaks.fwhm_nm
    full = _touched(wavelength_nm, bad.full, lowest, highest)
    other = _touched(wavelength_nm, _not_full(bad), lowest, highest)
    doubted = {name for name, found in reduction.evidence.items() if found.status == "uncertain"}
    flags = []
    for k in range(len(peaks)):
        said = ["saturated"] if full[k] else []
        said += ["bad channel"] if other[k] else []
        said += [] if peaks.settled[k] else ["unsettled"]
        said += ["uncertain"] if named.element[k] in doubted else []
        said += [f"shared with {', '.join(named.shared[k])}"] if named.shared[k] else []
        flags.append(BETWEEN_FLAGS.join(said))
    return flags


def _not_full(bad: BadChannels) -> BoolArray:
    return bad.missing | bad.dead | bad.hot


def _touched(x: FloatArray, bad: BoolArray, lowest: FloatArray, highest: FloatArray) -> BoolArray:
    """Whether a bad channel lies between the positions, shape (k,)."""
    places = x[bad]
    return np.searchsorted(places, lowest) < np.searchsorted(places, highest)
