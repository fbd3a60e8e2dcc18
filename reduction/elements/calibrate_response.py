"""An instrument's response from what is known of the light: a lamp with a certificate, or lines."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..plasma.boltzmann import CALIBRATION, Bend, misfit, slopes
from ..plasma.plot_fit import GLOBAL, trust
from ..plasma.response import LOOSE, OPEN, knots, stiffness
from ..spectrum.response import KnownResponse
from ..spectrum.spectrum import FloatArray, Spectrum
from .identify import Identified
from .offsets import seams
from .response import LEAST_LINES

SMOOTH_NM = 2.0
LEAST_CHANNELS = 5
ENOUGH_SPECTRA = 5  # of fewer, what a plasma lacks may be taken for the instrument's
OWN_OF_FEW = 1.0  # which they cannot tell
# What each spectrum's own plasma may add, as a part of what a response may be beforehand.
OWN = (0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0)
SEAM_NM, NEAR_NM = 1.05, 2.0  # knots of a seam; places of one
DOUBTED = 0.5  # of a spectrum's deviation from the others
TURNS = 10
TOLD = 1e-6  # of all that a spectrum tells, that a direction must be told
HARDLY = 0.1  # weight of a spectrum that is left out


@dataclass(frozen=True, slots=True, eq=False)
class FromLines:
    """The response, how many spectra told it, and from where to where (vacuum nm) their lines are."""

    response: KnownResponse
    spectra: int
    range_nm: tuple[float, float]


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


def from_lines(x: FloatArray, found: Sequence[Identified | None]) -> FromLines:
    """One response for all spectra of an instrument, by the lines of each; x: its axis, nm, (n,).

    Each spectrum's plot is made straight where it is, and what its own state and amounts may do is taken
    out; what is left it tells of the response, with all covariances, and all are added up (generalised
    least squares). A spectrum's plasma lacks something of its own, too, which looks like a response: how
    much is what makes all the spectra likeliest, and the errors count it; fewer than ENOUGH_SPECTRA
    cannot tell, and it is taken for large. A spectrum that is far from the others loses its weight. Raises
    ValueError where none has enough lines.
    """
    told = [one for one in found if one is not None and _tells(one)]
    if not told:
        raise ValueError("no spectrum has enough lines to tell a response; a lamp does (--lamp)")
    jumps = _jumps(x, told)
    at = knots((float(x[0]), float(x[-1])), jumps)
    usual = np.asarray(np.linalg.inv(stiffness(at, jumps, LOOSE)), np.float64)
    each = [_told_by(one, at) for one in told]
    sizes = OWN if len(told) >= ENOUGH_SPECTRA else (OWN_OF_FEW,)
    of_own = [_shared(each, stiffness(at, jumps, OPEN), own**2 * usual) for own in sizes]
    _, log, covariance, weight = max(of_own, key=lambda one: one[0])
    middle = np.eye(len(at)) - 1.0 / len(at)  # the scale of a response is nobody's concern
    error = np.sqrt(np.diag(middle @ covariance @ middle))
    seen = np.concatenate([one.lines.vacuum_nm for one in told if one.lines is not None])
    response = KnownResponse(at, np.exp(log - log.max()), error)
    return FromLines(response, int(np.sum(weight > HARDLY)), (float(seen.min()), float(seen.max())))


def _tells(found: Identified) -> bool:
    enough = found.lines is not None and len(found.lines) >= LEAST_LINES
    return enough and found.plot is not None and found.bend is not None


def _jumps(x: FloatArray, found: Sequence[Identified]) -> FloatArray:
    """Where the pitch jumps, and where a third of the spectra or more found the gain to; nm, ascending."""
    of_axis, votes = seams(x), np.empty(0)
    for one in found:
        assert one.bend is not None
        pair = one.bend.knots_nm
        votes = np.append(votes, (0.5 * (pair[1:] + pair[:-1]))[np.diff(pair) < SEAM_NM])
    votes = np.sort(votes[np.abs(votes[:, None] - of_axis).min(axis=1, initial=np.inf) > NEAR_NM])
    jumps = of_axis
    while len(votes):
        near = np.abs(votes[:, None] - votes) < NEAR_NM
        own = near[np.argmax(near.sum(axis=1))]
        if own.sum() < max(len(found) / 3, 2):
            break
        jumps = np.append(jumps, np.median(votes[own]))
        votes = votes[np.abs(votes - jumps[-1]) > 2 * NEAR_NM]
    return np.sort(jumps)


def _told_by(found: Identified, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What a spectrum tells of ln(response) at knots (nm): the inverse of its covariance, (k, k), which may
    be singular, and that times ln(response), (k,)."""
    plot, lines = found.plot, found.lines
    assert plot is not None and lines is not None
    k, gain = len(at), np.zeros(len(at))
    if plot.response is not None:
        lines = replace(lines, log_area=lines.log_area + plot.response.at(lines.vacuum_nm))
        gain = plot.response.at(at)
    residual, slope, prior, _ = slopes(lines, plot, Bend(at, gain, np.zeros((k, k))))
    sigma = np.hypot(lines.error, CALIBRATION)
    sigma = np.hypot(sigma, misfit(residual, sigma, len(lines) - GLOBAL - len(plot.names)))
    weight = trust(residual / sigma) / sigma**2
    normal, toward = slope.T @ (weight[:, None] * slope) + prior, slope.T @ (weight * residual)
    taken = np.linalg.solve(normal[:-k, :-k], normal[:-k, -k:])
    inverse = normal[-k:, -k:] - normal[-k:, :-k] @ taken
    return inverse, toward[-k:] - taken.T @ toward[:-k] + inverse @ gain


def _shared(
    each: Sequence[tuple[FloatArray, FloatArray]], stiff: FloatArray, own: FloatArray
) -> tuple[float, FloatArray, FloatArray, FloatArray]:
    """ln of how likely the spectra are, ln(response) at the knots, its covariance, and the spectra's weights.
    stiff: what is known beforehand; own: covariance of what each spectrum's own plasma adds to it."""
    inverse_own, eye = np.linalg.inv(own), np.eye(len(own))
    told = [
        (i @ np.linalg.solve(eye + own @ i, eye), np.linalg.solve(eye + i @ own, y))
        for i, y in each
    ]
    weight, log, normal = np.ones(len(each)), np.zeros(len(own)), stiff
    for _ in range(TURNS):
        normal = stiff + sum(w * i for w, (i, _) in zip(weight, told, strict=True))
        log = np.linalg.solve(normal, sum(w * y for w, (_, y) in zip(weight, told, strict=True)))
        off = [
            (y - i @ log) @ np.linalg.pinv(i, TOLD, hermitian=True) @ (y - i @ log) for i, y in told
        ]
        free = [np.linalg.matrix_rank(i, TOLD * np.trace(i), hermitian=True) for i, _ in told]
        weight = trust(DOUBTED * np.sqrt(np.array(off) / np.maximum(free, 1)))
    likely = 0.0
    for inverse, y in each:
        left, both = y - inverse @ log, inverse_own + inverse
        likely += 0.5 * left @ np.linalg.solve(both, left)
        likely -= 0.5 * (np.linalg.slogdet(both)[1] - np.linalg.slogdet(inverse_own)[1])
    covariance = np.asarray(np.linalg.inv(normal), np.float64)
    return float(likely), np.asarray(log, np.float64), covariance, np.asarray(weight, np.float64)
