"""Light that lines without a peak of their own add to the peaks of others.

A spectrograph merges faint lines with the bright one beside them, and the fit of the peak counts their
light: where ln(area) should be 0.4 to 0.7 too great by it, measured and made lines are 0.4 too bright, the
faint and crowded ones of iron and titanium most.
"""

from dataclasses import replace

import numpy as np

from ..peaks.profiles import Profiles
from ..plasma.boltzmann import PlotLines, fit_plot
from ..plasma.growth import log_depth_of_unit, log_kept
from ..plasma.strengths import atoms, log_strengths
from ..spectrum.spectrum import FloatArray, IntArray
from .identify import Identified, known_density, missing_lines

WIDER_THAN_SLIT = 1.1  # of a peak
IN_PEAK = 0.7  # of such light; the rest is taken for background
DOUBTFUL = 0.4  # of what is taken off: composition, wavelengths, shapes
MARGIN_NM = 2.0


def without_merged(found: Identified, profiles: Profiles) -> Identified:
    """The plot fitted again, such light taken off its lines; as it was where there is no plot."""
    plot, lines = found.plot, found.lines
    if plot is None or lines is None:
        return found
    added = _added(found, profiles)
    response = plot.response
    gain = 0.0 if response is None else response.at(lines.vacuum_nm)
    lines = replace(
        lines,
        log_area=lines.log_area + gain - added,
        relative=np.hypot(lines.relative, DOUBTFUL * added),
        error=np.hypot(lines.error, DOUBTFUL * added),
    )
    bend, missing = found.bend, None
    if bend is not None and response is not None:
        bend = replace(bend, start=response.log_gain)
    if found.response is not None:
        missing = missing_lines(found.catalogue, found.expected, found.matched, found.indexed)
    again = fit_plot(
        lines, known_density(found.hydrogen), plot.temperature_k, bend=bend, missing=missing, scattered=True
    )  # fmt: skip
    if again is None:
        return found
    if again.response is not None:
        gain = again.response.at(lines.vacuum_nm)
        lines = replace(lines, log_area=lines.log_area - gain)
    return replace(found, plot=again, lines=lines, response=found.response and again.response)


def _added(found: Identified, profiles: Profiles) -> FloatArray:
    """ln of how much brighter each line of the plot is by the light of others in its peak, (n,)."""
    lines, plot = found.lines, found.plot
    assert lines is not None and plot is not None
    rows = _rows(lines, plot.names)
    light, nm = _light(found, rows), atoms().wavelength_nm[rows]
    centre = profiles.peaks.centre_nm
    shown = found.offsets.shown(nm)
    peak = _nearest(centre, shown)
    sigma = WIDER_THAN_SLIT * np.interp(centre, profiles.wavelength_nm, profiles.slit.sigma_nm)
    # What a profile of this width finds of a line beside its middle.
    inside = light * np.exp(-0.25 * ((shown - centre[peak]) / sigma[peak]) ** 2)
    total = np.bincount(peak, inside, len(centre))
    own = np.searchsorted(rows, lines.rows)
    its = _nearest(centre, found.offsets.shown(lines.vacuum_nm))
    mine = np.where(peak[own] == its[lines.entry], inside[own], 0.0)
    others = np.maximum(total[its] - np.bincount(lines.entry, mine, len(lines)), 0.0)
    return np.log1p(
        IN_PEAK * others / np.maximum(np.bincount(lines.entry, light[own], len(lines)), 1e-300)
    )


def _rows(lines: PlotLines, names: IntArray) -> IntArray:
    """Of the line table, all lines of the plot's elements near its lines, ascending."""
    a = atoms()
    near = (a.wavelength_nm > lines.vacuum_nm.min() - MARGIN_NM) & (
        a.wavelength_nm < lines.vacuum_nm.max() + MARGIN_NM
    )
    return np.union1d(np.flatnonzero(near & np.isin(a.element, names)), lines.rows)


def _light(found: Identified, rows: IntArray) -> FloatArray:
    """Expected areas, arbitrary unit, self-absorption and response counted; (rows,)."""
    plot, a = found.plot, atoms()
    assert plot is not None
    nm, density = a.wavelength_nm[rows], 10**plot.log10_ne
    log = log_strengths(rows, plot.temperature_k, density) + plot.log_scale[a.element[rows]]
    depth = log_depth_of_unit(nm, a.width_nm[rows] * density / 1e17, plot.temperature_k)
    log = log + log_kept(plot.log_opacity + log + depth)
    if plot.response is not None:
        log = log + plot.response.at(nm)
    return np.exp(np.nan_to_num(log - np.nanmax(log), nan=-np.inf))


def _nearest(ascending: FloatArray, at: FloatArray) -> IntArray:
    after = np.clip(np.searchsorted(ascending, at), 1, max(len(ascending) - 1, 1))
    if len(ascending) < 2:
        return np.zeros(len(at), np.int64)
    return after - (at - ascending[after - 1] < ascending[after] - at)
