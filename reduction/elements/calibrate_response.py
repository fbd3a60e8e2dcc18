"""An instrument's response from what is known of the light: a lamp with a certificate, or lines."""

from collections.abc import Sequence

import numpy as np

from ..plasma.response import Response
from ..spectrum.response import KnownResponse
from ..spectrum.spectrum import FloatArray, Spectrum
from .offsets import seams

SMOOTH_NM = 2.0
LEAST_CHANNELS = 5


def from_lamp(lamp: Spectrum, certified_nm: FloatArray, certified: FloatArray) -> KnownResponse:
    """Counts of a lamp without dark counts, over its certified radiance; in steps of 2 nm.

    A lamp has no lines, so that the median of a step tells it; no step spans a seam of detectors.
    Between the certificate's wavelengths ln of it is joined smoothly over their inverse, in which a
    glowing filament's is nearly straight (Wien). Wavelengths that it does not have are left out. Errors
    count the scatter of the channels; what the certificate may be off by is not in them. Raises
    ValueError where nothing is left.
    """
    from scipy.interpolate import PchipInterpolator  # here: no other command needs it

    x, counts = lamp.wavelength_nm, lamp.intensity
    light = PchipInterpolator(-1 / certified_nm, np.log(certified))
    known = (x >= certified_nm[0]) & (x <= certified_nm[-1]) & np.isfinite(counts)
    ratio = counts / np.exp(light(-1 / np.clip(x, certified_nm[0], certified_nm[-1])))
    part = np.searchsorted(seams(x), x)
    step = np.floor((x - x[0]) / SMOOTH_NM) + 1e6 * part
    rows = []
    for one in np.unique(step[known]):
        inside = known & (step == one)
        middle = float(np.median(ratio[inside]))
        if inside.sum() < LEAST_CHANNELS or middle <= 0:
            continue
        scatter = 1.4826 * float(np.median(np.abs(ratio[inside] - middle)))
        error = 1.2533 * scatter / np.sqrt(inside.sum()) / middle  # of a median
        rows.append((float(x[inside].mean()), middle, error))
    if len(rows) < 2:
        raise ValueError("the lamp's light is nowhere above the dark where the certificate has it")
    nm, response, error = np.array(rows).T
    return KnownResponse(nm, response / response.max(), error)


def from_lines(told: Sequence[Response]) -> KnownResponse:
    """The mean of responses that the lines of spectra tell, weighted by their errors.

    The error is the greater of what the fits say and of how they scatter. Raises ValueError for none.
    """
    if not told:
        raise ValueError("no spectrum has lines that tell a response, or it is level already")
    at = np.unique(np.concatenate([one.knots_nm for one in told]))
    log = np.array([one.at(at) for one in told])
    log -= log.mean(axis=1, keepdims=True)  # the scale of a response is nobody's concern
    weight = 1.0 / np.array([one.error_at(at) for one in told]) ** 2
    mean = np.sum(weight * log, axis=0) / weight.sum(axis=0)
    by_fit = 1.0 / np.sqrt(weight.sum(axis=0))
    scatter = np.sqrt(np.sum(weight * (log - mean) ** 2, axis=0) / weight.sum(axis=0))
    by_scatter = scatter / np.sqrt(max(len(told) - 1, 1))
    return KnownResponse(at, np.exp(mean - mean.max()), np.maximum(by_fit, by_scatter))
