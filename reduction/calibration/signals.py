"""What a calibration is made from: areas of chosen lines, each with its noise, and the total light."""

from dataclasses import dataclass

import numpy as np

from ..elements.elements import TOLERANCE_NM, Line, predominant_line
from ..lines.air import to_air
from ..lines.lines import lines_of
from ..peaks.render import render
from ..plasma.plasma import relative_strengths
from ..reduce import Reduction

NEAR_NM = 0.1  # of a wavelength that a person writes, in air, from the line that is meant
REACH = 3.0  # widths of the slit on both sides, where no peak was fitted
CORE = 1.5  # within which no channel may be bad
BESIDE_NM = 4.0  # other peaks whose feet count there
BLEND_NM = 0.05
CANDIDATES = 8  # lines that are tried for an element
APART_NM = 0.15  # from one another
LEAST_STRENGTH = 3e-3  # of the strongest


@dataclass(frozen=True, slots=True)
class Signal:
    """An area and the noise of such an area without its own light, both in counts nm.

    Where no peak was fitted the area is measured all the same, and may be below 0: what stands
    below a threshold is not 0.
    """

    area: float
    noise: float


def line_near(element: str, air_nm: float | None = None) -> Line:
    """The predominant line, or the strongest near a wavelength in air.

    Raises ValueError if the table has none there.
    """
    if air_nm is None:
        return predominant_line(element)
    lines = lines_of(element)
    shown = to_air(lines.wavelength_nm)
    strengths = np.where(np.abs(shown - air_nm) < NEAR_NM, relative_strengths(lines), -1.0)
    best = int(np.argmax(strengths))
    if strengths[best] < 0:
        nearest = float(shown[np.argmin(np.abs(shown - air_nm))])
        raise ValueError(
            f"no line of {element} within {NEAR_NM} nm of {air_nm:g} nm in air; the nearest is "
            f"{nearest:.3f} nm (`labrun lines {element}` shows all)"
        )
    blend = np.abs(lines.wavelength_nm - lines.wavelength_nm[best]) < BLEND_NM
    blend &= lines.stage == lines.stage[best]
    mean = np.average(lines.wavelength_nm[blend], weights=np.maximum(strengths[blend], 1e-30))
    return Line(element, int(lines.stage[best]), float(mean))


def candidates(element: str, range_nm: tuple[float, float]) -> list[Line]:
    """The predominant line, then the strongest others in a range of wavelengths in air.

    Raises ValueError for an element without lines in the table.
    """
    found = [predominant_line(element)]
    lines = lines_of(element)
    shown, strengths = to_air(lines.wavelength_nm), relative_strengths(lines)
    inside = (shown > range_nm[0] + 1) & (shown < range_nm[1] - 1)
    floor = LEAST_STRENGTH * float(np.max(strengths[inside], initial=0.0))
    for k in np.argsort(-strengths):
        if len(found) == CANDIDATES or strengths[k] < floor:
            break
        away = [abs(one.wavelength_nm - lines.wavelength_nm[k]) for one in found]
        if inside[k] and min(away) > APART_NM:
            found.append(line_near(element, float(shown[k])))
    return found


def line_signal(reduction: Reduction, line: Line) -> Signal | None:
    """The signal of a line; None if the spectrum does not reach it, or has bad or full channels there."""
    profiles, peaks = reduction.profiles, reduction.peaks
    x, noise = profiles.wavelength_nm, profiles.noise
    place = reduction.offsets.place(line.wavelength_nm)
    at = int(np.searchsorted(x, place))
    if not 1 <= at < len(x) - 1:
        return None
    sigma = float(max(profiles.slit.sigma_nm[at], 0.6 * (x[at] - x[at - 1])))
    own = slice(*np.searchsorted(x, [place - REACH * sigma, place + REACH * sigma]))
    shape = np.exp(-0.5 * ((x[own] - place) / sigma) ** 2) / (sigma * np.sqrt(2 * np.pi))
    core = slice(*np.searchsorted(x, [place - CORE * sigma, place + CORE * sigma]))
    if profiles.bad[core].any():
        return None
    weight = np.where(profiles.bad[own], 0.0, shape / noise[own] ** 2)
    told = float(weight @ shape)
    near = np.abs(peaks.centre_nm - place)
    bright = np.flatnonzero((peaks.area > 0) & (near < TOLERANCE_NM))
    if len(bright):
        best = int(bright[np.argmin(near[bright])])
        return Signal(float(peaks.area[best]), told**-0.5)
    beside = peaks.where(near < BESIDE_NM)
    left = profiles.net[own] - render(x[own], beside, 0.05 * noise[own])
    return Signal(float(weight @ left) / told, told**-0.5)


def total_light(reduction: Reduction) -> float:
    """All counts over the axis, continuum included, counts nm."""
    return float(np.trapezoid(reduction.profiles.counts, reduction.profiles.wavelength_nm))
