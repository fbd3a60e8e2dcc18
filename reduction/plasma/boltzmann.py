"""Temperature and density of the plasma from all lines of all elements in one Saha-Boltzmann plot.

ln(area) of each line is a straight function of 1/T (Boltzmann), of ln n_e where it is an ion's
(Saha), of its element's amount, and bends where the line absorbs itself (curve of growth, one
constant for the spectrum). All are fitted together, outliers down-weighted (Yalcin et al., Appl.
Phys. B 68, 121 (1999) for the plot; Aguilera and Aragon, Spectrochim. Acta B 62, 378 (2007) for
many elements in one). The instrument's response is fitted with them, as a nuisance: what it might
be widens the errors of all else.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..peaks.levenberg import factorise, solve
from ..spectrum.curve import median
from ..spectrum.kernel import kernel
from ..spectrum.spectrum import BoolArray, FloatArray, IntArray
from .growth import growth_table, log_depth_of_unit, log_kept
from .plot_fit import (
    COOLEST_K,
    GLOBAL,
    HOTTEST_K,
    LEAST_LN_NE,
    MOST_LN_NE,
    OUTLIER,
    as_thin,
    depths,
    gauss_newton,
    inverse,
    rows_of_table,
    trust,
    widest,
)
from .response import Response, between
from .strengths import GRID_K, atoms, log_strengths, present

USUAL_K, USUAL_SPREAD = 10_500.0, 0.35  # of ln T, where the lines do not tell
USUAL_LOG_NE, USUAL_NE_SPREAD = float(np.log(8e16)), 1.2
CALIBRATION = 0.08  # of ln(area): efficiency, background, the model itself
# What one zone in equilibrium lacks, as a part of T: at all, and if the thicker lines lost all of their
# light, else by the part that they lost: once they are thick, more opacity makes T no more wrong. Measured
# on spectra of one and two zones (benchmarks/intervals.py).
UNIFORM, THICK = 0.012, 0.05
# The same for each unit of ln(area) by which lines scatter beyond their errors: what makes them do so (an
# echelle's orders) is alike in lines that lie together, and hides the faint ones of high levels.
UNLIKE = 0.08
MOST_BY_GAIN = 0.96  # of the variance of ln(temperature), that the response's freedom may make
LEAST_SLOPE = 0.2  # of the lines' mean influence
FEW = 10.0  # lines, by which the scatter of the others is taken to be as their errors say
FAR, USUAL_SQUARE = 9.0, 0.995  # z^2 of an outlier; mean of z^2 of a normal law, at most FAR each
MOST_MISFIT, HALVINGS = 2.0, 12  # of ln(area)
STEPS = 10
OPACITY_KNOWN = 0.05  # 1 / variance of its ln beforehand: hardly anything
BESIDE = np.array([0.01, 0.05, 0.05])  # of ln T, ln n_e and opacity, for differences
LEAST_LINES = 4
LEAST_SPREAD_EV = 0.8


@dataclass(frozen=True, slots=True, eq=False)
class PlotLines:
    """Lines for the plot; rows are one line (or unresolved multiplet) each, shape (n,).

    log_area, error: ln counts nm. element: index. rows, entry: rows of the line table and the
    line that each belongs to. vacuum_nm, width_nm (at 1e17 per cm3), e_k_ev, ion: of the leader.
    relative: the part of `error` that is not of the transition probability.
    """

    log_area: FloatArray
    error: FloatArray
    element: IntArray
    rows: IntArray
    entry: IntArray
    vacuum_nm: FloatArray
    width_nm: FloatArray
    e_k_ev: FloatArray
    ion: np.ndarray
    relative: FloatArray

    def __add__(self, other: "PlotLines") -> "PlotLines":
        """Both, one after the other."""
        pairs = {name: (getattr(self, name), getattr(other, name)) for name in self.__slots__}
        pairs["entry"] = self.entry, other.entry + len(self)
        return PlotLines(*(np.concatenate(pair) for pair in pairs.values()))

    def where(self, chosen: BoolArray) -> "PlotLines":
        """Some of the lines; chosen: (n,)."""
        values = {name: getattr(self, name) for name in self.__slots__}
        each = {name: values[name][chosen] for name in values if name not in ("rows", "entry")}
        own = chosen[self.entry]
        entry = (np.cumsum(chosen) - 1)[self.entry[own]]
        return PlotLines(rows=self.rows[own], entry=entry, **each)

    def __len__(self) -> int:
        return len(self.log_area)

    def thin(
        self, temperature_k: float | FloatArray, density_per_cm3: float | FloatArray
    ) -> FloatArray:
        """ln of the thin area for one atom of the element, (..., n), at temperatures and densities (...)."""
        log = log_strengths(self.rows, temperature_k, density_per_cm3)
        top = log.max(axis=-1, initial=0.0, keepdims=True)
        first = np.ones(len(self.rows), np.bool_)
        np.not_equal(self.entry[1:], self.entry[:-1], out=first[1:])
        begin = np.flatnonzero(first)  # the rows of a line are in one run
        thin = np.full((*log.shape[:-1], len(self)), -np.inf)
        thin[..., self.entry[begin]] = (
            np.log(np.add.reduceat(np.exp(log - top), begin, axis=-1)) + top
        )
        return thin


@dataclass(frozen=True, slots=True, eq=False)
class Plot:
    """The fitted plot. Errors are standard errors, by what the lines scatter and what the model lacks.

    log_opacity: the constant of the spectrum (see growth). log_scale: ln of each element's amount,
    shape (e,), NaN where it has no line. kept: part of its light that each line kept. residual:
    ln(area) minus the model. flags: warnings for the user. response: None where a fixed one was
    assumed. names, covariance: elements of the plot, (k,), and the covariance of ln of their
    amounts, (k, k), all else unknown. by_scatter: the same by what the lines really scatter (see
    `scatter`). blind: by how much larger the error of ln(temperature) is than it were if the response
    were known: so much more of what the model lacks goes into it.
    """

    temperature_k: float
    temperature_error_k: float
    log10_ne: float
    log10_ne_error: float
    log_opacity: float
    log_scale: FloatArray
    kept: FloatArray
    residual: FloatArray
    chi2: float
    flags: tuple[str, ...]
    response: Response | None
    names: IntArray
    covariance: FloatArray
    by_scatter: FloatArray
    blind: float

    @property
    def lost(self) -> float:
        """The part of their light that the thicker lines lost."""
        return _lost(self.kept)

    @property
    def temperature_at_bound(self) -> bool:
        """Whether the fit ended at the lowest or highest temperature: no measurement."""
        return not 1.001 * COOLEST_K < self.temperature_k < 0.999 * HOTTEST_K

    @property
    def density_at_bound(self) -> bool:
        """The same of the density."""
        ln = self.log10_ne * float(np.log(10))
        return not LEAST_LN_NE + 0.01 < ln < MOST_LN_NE - 0.01


@dataclass(frozen=True, slots=True)
class Known:
    """What is known before the plot, as a mean and a standard deviation of a logarithm."""

    mean: float
    spread: float


@dataclass(frozen=True, slots=True, eq=False)
class Bend:
    """The response beforehand: knots (vacuum nm) and where to begin from, (k,); stiff: the inverse
    of its covariance, (k, k)."""

    knots_nm: FloatArray
    start: FloatArray
    stiff: FloatArray


def fit_plot(
    lines: PlotLines,
    density: Known | None = None,
    start_k: float = USUAL_K,
    most_steps: int = STEPS,
    bend: Bend | None = None,
    missing: PlotLines | None = None,
    scattered: bool = False,
    thickest: float = 0.5,
) -> Plot | None:
    """Fit the plot; None if the lines do not determine a temperature.

    density: ln n_e (per cm3) from elsewhere, such as the width of H-alpha. bend: the response is
    fitted, too. missing: lines that should be brighter than `log_area` and are not seen. scattered:
    where lines scatter by more than their errors, all of them do by as much more, strong ones too,
    and the plot is fitted again; `chi2` stays that of their own errors. thickest: optical depth of the
    thickest line to begin from.
    """
    if len(lines) < LEAST_LINES:
        return None
    own, n_seen = lines, len(lines)
    if missing is not None:  # of an element without a line that is seen they tell nothing
        has_line = np.zeros(len(atoms().elements), np.bool_)
        has_line[own.element] = True
        lines = own + missing.where(has_line[missing.element])
    names, which = present(lines.element)
    density = density or Known(USUAL_LOG_NE, USUAL_NE_SPREAD)
    bend = bend or Bend(np.empty(0), np.empty(0), np.empty((0, 0)))
    a = atoms()
    p, covariance, prior, kept, residual, sigma, own_chi2, chi2, more = _fitted(
        (lines.log_area, lines.error, which, lines.ion, lines.e_k_ev, lines.vacuum_nm, lines.width_nm),
        (lines.rows, lines.entry, a.ion, a.log_ga, a.e_k_ev),
        names, (a.log_u, GRID_K, a.limit_ev, growth_table()), bend.knots_nm, bend.start, bend.stiff,
        n_seen, density.mean, density.spread, start_k, most_steps, scattered, thickest,
    )  # fmt: skip
    plot = _as_plot(
        p, covariance, kept[:n_seen], residual[:n_seen], sigma[:n_seen], own, names,
        which[:n_seen], bend, prior, chi2, more,
    )  # fmt: skip
    return replace(plot, chi2=own_chi2) if more else plot


@kernel
def _fitted(
    lines, table, names, tables, knots_nm, gain, stiff, n_seen, log_density, density_spread, start_k,
    most_steps, scattered, depth,
):  # fmt: skip
    """Parameters, their covariance, and the weights of what is known beforehand. Of the lines, (n,): ln of
    what they kept, what is left over, its error. chi2 by the lines' own errors and by those, and by how much
    they scatter beyond their own."""
    log_area, error, which, of_ion, e_k_ev, vacuum_nm, width_nm = lines
    n, k, n_knots, rows = len(log_area), len(names), len(knots_nm), rows_of_table(table, which)
    ion, knot, part = np.empty(n, np.int64), np.zeros(n, np.int64), np.zeros(n)
    if n_knots:
        knot, part = between(knots_nm, vacuum_nm)
    sigma, level = np.empty(n), log_area.copy()
    for i in range(n):
        ion[i], sigma[i] = of_ion[i], np.sqrt(error[i] ** 2 + CALIBRATION**2)
        if n_knots:
            level[i] -= (1.0 - part[i]) * gain[knot[i]] + part[i] * gain[knot[i] + 1]
    p, prior = np.zeros(GLOBAL + k + n_knots), np.zeros(GLOBAL + k + n_knots)
    p[0], p[1] = np.log(start_k), log_density
    thin, amount = as_thin(p[0], p[1], level, n_seen, which, rows, names, tables)
    for e in range(k):
        p[GLOBAL + e] = amount[e]
    for b in range(n_knots):
        p[GLOBAL + k + b] = gain[b]
    kept, residual, weight = np.empty(n), np.empty(n), np.empty(n)
    depths(p, thin, which, vacuum_nm, width_nm, residual)
    thickest = -np.inf
    for i in range(n_seen):
        thickest = max(thickest, residual[i])
    p[2] = np.log(depth) - thickest
    toward = p.copy()
    toward[0] = np.log(USUAL_K)
    prior[0], prior[1], prior[2] = 1 / USUAL_SPREAD**2, 1 / density_spread**2, OPACITY_KNOWN
    own_chi2, chi2, more = 0.0, 0.0, 0.0
    while True:
        covariance = gauss_newton(
            p,
            (log_area, sigma, which, ion, e_k_ev, vacuum_nm, width_nm, n_seen, knot, part),
            rows, names, tables, toward, prior, stiff, most_steps, thin, kept, residual, weight,
            np.zeros((len(p), len(p))),
        )  # fmt: skip
        told, squares = 0.0, 0.0
        for i in range(n_seen):
            z = residual[i] / sigma[i]
            told += trust(z)
            squares += trust(z) * z * z
        chi2 = squares / max(
            told - (GLOBAL + k) + 1.0, 1.0
        )  # the priors know one of the parameters
        if more > 0.0 or not scattered:
            break
        own_chi2 = chi2
        more = misfit(residual[:n_seen], sigma[:n_seen], n_seen - GLOBAL - k)
        if more == 0.0:
            break
        for i in range(n):
            sigma[i] = np.hypot(sigma[i], more)
    return p, covariance, prior, kept, residual, sigma, own_chi2, chi2, more


@kernel
def misfit(residual, sigma, free):
    """By how much lines scatter (one sigma of ln(area)) beyond their errors; 0 if they do not.

    residual, sigma: shape (n,). free: degrees of freedom. With it in the errors the mean square of
    residual / error is 1, outliers counted as 3 errors (Paule and Mandel, J. Res. NBS 87, 377 (1982)).
    """
    low, high, middle = 0.0, MOST_MISFIT, 0.0
    for turn in range(HALVINGS + 1):
        total = 0.0
        for i in range(len(residual)):
            variance = sigma[i] * sigma[i] + middle * middle
            total += min(residual[i] * residual[i] / variance, FAR)
        much = total > USUAL_SQUARE * max(free, 1)
        if turn == 0 and not much:
            return 0.0
        low, high = (middle, high) if much else (low, middle)
        middle = 0.5 * (low + high)
    return middle


@kernel
def scatter(z, free):
    """Variance of what is fitted to lines over that of their weights alone, z: residual / error, (n,).

    Where lines agree better than the classes of their transition probabilities allow, all is known better.
    A weighted chi2 does not tell: outliers lose their weight, and of honest errors it is 0.67 (Huber, Ann.
    Stat. 1, 799 (1973)). FEW lines more are counted that scatter as their errors say.
    """
    says, squares, slope, free = 0.0, 0.0, 0.0, max(free, 1.0)
    for i in range(len(z)):
        say = trust(z[i])
        says += say / len(z)
        squares += (say * z[i]) ** 2
        # Of the influence, say * z.
        slope += (say - 4.0 * (z[i] / OUTLIER) ** 2 * say * np.sqrt(say)) / len(z)
    own = says * squares / free / max(slope, LEAST_SLOPE) ** 2
    return float((FEW + free * own) / (FEW + free))


def slopes(
    lines: PlotLines, plot: Plot, bend: Bend
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """The plot made straight where it is. Residuals of any lines of its elements, (n,), and how their
    ln(area) grows with ln T, ln n_e, opacity, amounts and the response's knots, (n, p); the inverse of the
    parameters' covariance beforehand, (p, p), and the gradient that the response's own has there, (p,)."""
    which = np.searchsorted(plot.names, lines.element)
    k, n_knots = len(plot.names), len(bend.knots_nm)
    at = np.array([np.log(plot.temperature_k), plot.log10_ne * np.log(10), plot.log_opacity])
    # One step of each, all at once.
    at = at[:, None] + np.eye(3, 4, 1) * BESIDE[:, None]
    kelvin, density, opacity = np.exp(at[0]), np.exp(at[1]), at[2]
    thin = lines.thin(kelvin, density) + plot.log_scale[lines.element]
    depth = [
        log_depth_of_unit(lines.vacuum_nm, lines.width_nm * ne / 1e17, t)
        for t, ne in zip(kelvin, density, strict=True)
    ]
    log_area = thin + log_kept(opacity[:, None] + thin + np.array(depth))
    slope, rows = np.zeros((len(lines), 3 + k + n_knots)), np.arange(len(lines))
    slope[:, :3] = ((log_area[1:] - log_area[0]) / BESIDE[:, None]).T
    slope[rows, 3 + which] = 1.0 + slope[:, 2]
    prior = np.diag(np.concatenate([
        [1 / USUAL_SPREAD**2, 1 / USUAL_NE_SPREAD**2, OPACITY_KNOWN], np.full(k + n_knots, 1e-9)
    ]))  # fmt: skip
    residual, off = lines.log_area - log_area[0], np.zeros(3 + k + n_knots)
    if n_knots:
        knot, part = between(bend.knots_nm, lines.vacuum_nm)
        slope[rows, 3 + k + knot] = 1.0 - part
        slope[rows, 4 + k + knot] = part
        prior[3 + k :, 3 + k :] += bend.stiff
        if plot.response is not None:
            gain = plot.response.at(bend.knots_nm)
            residual -= slope[:, 3 + k :] @ gain
            off[3 + k :] = -bend.stiff @ gain
    return residual, slope, prior, off


def _as_plot(
    p, covariance, kept, residual, sigma, lines, names, which, bend: Bend, prior, chi2, more
) -> Plot:  # fmt: skip
    k, n_knots = len(names), len(bend.knots_nm)
    # A response that was found bends to the lines, and takes as many of them as it has freedom from what is
    # known beforehand.
    bends = n_knots - float(np.sum(bend.stiff * covariance[3 + k :, 3 + k :]))
    by_scatter, by_gain = _scattered(
        covariance, prior, bend.stiff, scatter(residual / sigma, len(lines) - (3 + k) + 1.0 - bends)
    )  # fmt: skip
    own_heat = covariance[0, 0]
    covariance = covariance * max(chi2, 1.0)
    scale = np.full(len(atoms().elements), np.nan)
    scale[names] = p[3 : 3 + k]
    part = np.exp(kept)
    kelvin = float(np.exp(p[0]))
    flags = []
    if _leverage_ev(lines, which) < LEAST_SPREAD_EV:
        flags.append("upper levels lie close together")
    if np.min(part) < 0.7:
        flags.append("strong lines absorb themselves")
    response, blind = None, 1.0
    if n_knots:
        gain = covariance[3 + k :, 3 + k :]
        blind = float((1.0 - min(by_gain / own_heat, MOST_BY_GAIN)) ** -0.5)
        # The level itself is in the amounts: only differences along the axis have an error here.
        own = gain.diagonal() - 2.0 * gain.mean(axis=0) + gain.mean()
        response = Response(bend.knots_nm, p[3 + k :], np.sqrt(np.maximum(own, 0.0)))
    lack = np.hypot(blind * np.hypot(UNIFORM, THICK * _lost(part)), UNLIKE * more)
    by_heat = float(np.sqrt(max(by_scatter[0, 0], 0.0) + lack**2))
    # Light of ions and atoms that is not equally hot moves the density with T.
    turned = lack * by_scatter[0, 1] / by_scatter[0, 0]
    by_density = float(np.sqrt(max(by_scatter[1, 1], 0.0) + turned**2))
    plot = Plot(
        kelvin, kelvin * by_heat, float(p[1] / np.log(10)), by_density / float(np.log(10)),
        float(p[2]), scale, part, residual, chi2, tuple(flags), response, names,
        covariance[3 : 3 + k, 3 : 3 + k], by_scatter[3 : 3 + k, 3 : 3 + k], blind,
    )  # fmt: skip
    if plot.temperature_at_bound:
        flags.append("the lines do not tell the temperature")
    if plot.density_at_bound:
        flags.append("the lines do not tell the density")
    return replace(plot, flags=tuple(flags))


@kernel
def _scattered(covariance, prior, stiff, scale):
    """A covariance whose lines scatter by `scale` times the variance; what is known beforehand stays. And how
    much of the first parameter's variance the last ones, of which `stiff` is known, would tell."""
    n, before = len(prior), len(prior) - len(stiff)
    lower = np.zeros((n, n))
    normal = inverse(covariance, lower)
    for a in range(n):
        for b in range(a + 1):
            known = prior[a] if a == b else 0.0
            if b >= before:
                known += stiff[a - before, b - before]
            normal[a, b] = (normal[a, b] - known) / scale + known
    m, told = n - before, 0.0
    own, shared, step = np.empty((m, m)), np.empty(m), np.zeros(m)
    for a in range(m):
        shared[a] = covariance[0, before + a]
        for b in range(m):
            own[a, b] = covariance[before + a, before + b]
    if factorise(own, lower):
        solve(lower, shared, step)
    for a in range(m):
        told += shared[a] * step[a]
    return inverse(normal, lower), told


def _lost(kept: FloatArray) -> float:
    return 1.0 - float(median(np.sort(kept)[: max(3, len(kept) // 4)]))


def _leverage_ev(lines: PlotLines, which: IntArray) -> float:
    """The widest range of upper levels (eV, ionisation counted) within one element."""
    a = atoms()
    energy = lines.e_k_ev + np.where(lines.ion, a.limit_ev[lines.element], 0.0)
    return widest(energy, which, int(which.max()) + 1)
