"""Peaks of one spectrum, computed in the worker: the fits are compiled on first use."""

import base64
from importlib import import_module
from pathlib import Path
from typing import Any

REDUCTION = "labrun.reduction"
FAR = 60.0
"""A profile is drawn to this many of its widths."""


def peaks(asked: dict[str, Any]) -> dict[str, Any]:
    """Peaks with their elements, and background, fit and residual as Float32 in base64."""
    import numpy as np

    reduction = import_module(REDUCTION)
    spectrum = reduction.read_spectrum(Path(asked["path"])).without_bad()
    reduced = reduction.reduce_spectrum(spectrum, asked["elements"])
    nm = spectrum.wavelength_nm
    background = _background(spectrum)
    fit = background + _profiles(nm, reduced.peaks)
    residual = spectrum.intensity - fit
    element = {
        found.peak: name for name, found in reduced.elements.items() if found.peak is not None
    }
    widths = reduced.peaks.fwhm_nm
    centre = reduced.peaks.centre_nm
    height = np.interp(centre, nm, fit) - np.interp(centre, nm, background)
    rows = [
        {
            "nm": float(centre[i]), "area": float(reduced.peaks.area[i]),
            "width_nm": float(widths[i]), "height": float(height[i]), "element": element.get(i),
        }
        for i in range(len(centre))
    ]  # fmt: skip
    curves = np.concatenate([background, fit, residual]).astype("<f4").tobytes()
    return {
        "peaks": rows, "areas": {n: float(a) for n, a in reduced.areas.items()},
        "temperature_k": reduced.temperature_k, "noise": float(np.median(np.abs(residual))),
        "curves": base64.b64encode(curves).decode(),
    }  # fmt: skip


def _background(spectrum: Any) -> Any:
    reduction = import_module(REDUCTION)
    noise = reduction.local_noise(spectrum.intensity)
    calm = type(spectrum)(spectrum.wavelength_nm, reduction.despike(spectrum.intensity, noise))
    return reduction.estimate_background(calm, noise)


def _profiles(nm: Any, peaks: Any) -> Any:
    """The sum of all fitted profiles, each drawn where it is visible."""
    import numpy as np

    voigt = import_module(REDUCTION).voigt_profile
    total = np.zeros(len(nm))
    widths = peaks.fwhm_nm
    for i in range(len(peaks)):
        low, high = peaks.centre_nm[i] - FAR * widths[i], peaks.centre_nm[i] + FAR * widths[i]
        part = slice(*np.searchsorted(nm, [low, high]))
        if part.stop > part.start:
            total[part] += voigt(
                nm[part], peaks.area[i], peaks.centre_nm[i], peaks.sigma_nm[i], peaks.gamma_nm[i]
            )
    return total
