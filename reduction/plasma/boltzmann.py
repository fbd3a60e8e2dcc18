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

from ..spectrum.curve import median
from ..spectrum.kernel import kernel
from ..spectrum.spectrum import BoolArray, FloatArray, IntArray
from .growth import growth_table, log_depth_of_unit, log_kept
from .plot_fit import (
    COOLEST_K,
    HOTTEST_K,
    LEAST_LN_NE,
    MOST_LN_NE,
    OUTLIER,
    as_thin,
    gauss_newton,
    trust,
    widest,
)
from .response import Response, between
from .strengths import GRID_K, atoms, log_strengths, present

USUAL_K, USUAL_SPREAD = 10_500.0, 0.35  # of ln T, where the lines do not tell
USUAL_LOG_NE, USUAL_NE_SPREAD = float(np.log(8e16)), 1.2
CALIBRATION = 0.08  # of ln(area): efficiency, background, the model itself
# What one zone in equilibrium lacks, as a part of T: at all, and for each e-fold of light that the
# thicker lines lost. Measured on spectra of one and two zones, half of them (benchmarks/intervals.py).
UNIFORM, THICK = 0.012, 0.035
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
    """The fitted plot. Errors are standard errors, scaled by chi2 where that exceeds 1.

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
        """e-folds of light that the thicker lines lost."""
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
) -> Plot | None:
    """Fit the plot; None if the lines do not determine a temperature.

    density: ln n_e (per cm3) from elsewhere, such as the width of H-alpha. bend: the response is
    fitted, too. missing: lines that should be brighter than `log_area` and are not seen. scattered:
    where lines scatter by more than their errors, all of them do by as much more, strong ones too,
    and the plot is fitted again; `chi2` stays that of their own errors.
    """
    if len(lines) < LEAST_LINES:
        return None
    own, lines = lines, lines if missing is None else lines + missing
    names, which = present(lines.element)
    density = density or Known(USUAL_LOG_NE, USUAL_NE_SPREAD)
    bend = bend or Bend(np.empty(0), np.empty(0), np.empty((0, 0)))
    n, n_knots = len(lines), len(bend.knots_nm)
    n_seen = len(own)
    seen = np.arange(n) < n_seen
    knot, part = np.zeros(n, np.int64), np.zeros(n)
    if n_knots:
        knot, part = between(bend.knots_nm, lines.vacuum_nm)
    p, toward, prior = _start(lines, names, which, seen, density, start_k, bend.start, knot, part)
    thin, kept, residual, weight = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    sigma = np.sqrt(lines.error**2 + CALIBRATION**2)
    a = atoms()
    rows, chi2, more = _rows(lines, which), None, 0.0
    while True:
        covariance = gauss_newton(
            p,
            (lines.log_area, sigma, which, lines.ion.astype(np.int64), lines.e_k_ev, lines.vacuum_nm,
             lines.width_nm, seen, knot, part),
            rows,
            names,
            (a.log_u, GRID_K, a.limit_ev, growth_table()),
            toward, prior, bend.stiff, most_steps, thin, kept, residual, weight,
            np.zeros((len(p), len(p))),
        )  # fmt: skip
        plot = _as_plot(
            p, covariance, kept[:n_seen], residual[:n_seen], sigma[:n_seen], own, names,
            which[:n_seen], bend, prior, more,
        )  # fmt: skip
        if chi2 is not None:
            return replace(plot, chi2=chi2)
        more = misfit(plot.residual, sigma[:n_seen], n_seen - 3 - len(names)) if scattered else 0.0
        if more == 0.0:
            return plot
        chi2, sigma = plot.chi2, np.hypot(sigma, more)


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


def _rows(lines: PlotLines, which: IntArray):
    a = atoms()
    return (
        lines.entry, which[lines.entry], a.ion[lines.rows].astype(np.int64), a.log_ga[lines.rows],
        a.e_k_ev[lines.rows],
    )  # fmt: skip


def _start(lines: PlotLines, names, which, seen, density: Known, start_k: float, gain, knot, part):
    """Initial parameters, their priors, and the priors' weights (1 / variance)."""
    ne = float(np.exp(density.mean))
    a, says = atoms(), np.where(seen, 1.0, 1e-6)
    level = 0.0 if not len(gain) else (1.0 - part) * gain[knot] + part * gain[knot + 1]
    thin, scale = as_thin(
        float(np.log(start_k)), density.mean, lines.log_area - level, says, which,
        _rows(lines, which), names, (a.log_u, GRID_K, a.limit_ev),
    )  # fmt: skip
    depth = log_depth_of_unit(lines.vacuum_nm, lines.width_nm * ne / 1e17, start_k)
    opacity = np.log(0.5) - np.max((thin + scale[which] + depth)[seen])
    p = np.concatenate([[np.log(start_k), density.mean, opacity], scale, gain])
    toward, prior = p.copy(), np.zeros(len(p))
    toward[:2] = np.log(USUAL_K), density.mean
    prior[:3] = 1 / USUAL_SPREAD**2, 1 / density.spread**2, OPACITY_KNOWN
    return p, toward, prior


def _as_plot(
    p, covariance, kept, residual, sigma, lines, names, which, bend: Bend, prior, more
) -> Plot:  # fmt: skip
    say = trust(residual / sigma)
    k, n_knots = len(names), len(bend.knots_nm)
    free = max(float(say.sum()) - (3 + k) + 1.0, 1.0)  # the priors know one of the parameters
    chi2 = float(np.sum(say * (residual / sigma) ** 2) / free)
    # A response that was found bends to the lines, and takes as many of them as it has freedom from what is
    # known beforehand.
    bends = n_knots - float(np.sum(bend.stiff * covariance[3 + k :, 3 + k :]))
    by_scatter = _scattered(
        covariance, prior, bend.stiff, scatter(residual / sigma, len(lines) - (3 + k) + 1.0 - bends)
    )  # fmt: skip
    covariance = covariance * max(chi2, 1.0)
    error = np.sqrt(np.maximum(np.diag(covariance), 0.0))
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
        with_gain, gain = covariance[0, 3 + k :], covariance[3 + k :, 3 + k :]
        by_gain = float(with_gain @ np.linalg.solve(gain, with_gain))
        blind = float((1.0 - min(by_gain / covariance[0, 0], MOST_BY_GAIN)) ** -0.5)
        # The level itself is in the amounts: only differences along the axis have an error here.
        middle = np.eye(n_knots) - 1.0 / n_knots
        own = middle @ covariance[3 + k :, 3 + k :] @ middle
        response = Response(bend.knots_nm, p[3 + k :], np.sqrt(np.maximum(np.diag(own), 0.0)))
    lack = np.hypot(blind * np.hypot(UNIFORM, THICK * _lost(part)), UNLIKE * more)
    by_heat = float(np.sqrt(max(by_scatter[0, 0], 0.0) + lack**2))
    plot = Plot(
        kelvin, kelvin * by_heat, float(p[1] / np.log(10)), float(error[1] / np.log(10)),
        float(p[2]), scale, part, residual, chi2, tuple(flags), response, names,
        covariance[3 : 3 + k, 3 : 3 + k], by_scatter[3 : 3 + k, 3 : 3 + k], blind,
    )  # fmt: skip
    if plot.temperature_at_bound:
        flags.append("the lines do not tell the temperature")
    if plot.density_at_bound:
        flags.append("the lines do not tell the density")
    return replace(plot, flags=tuple(flags))


def _scattered(
    covariance: FloatArray, prior: FloatArray, stiff: FloatArray, scale: float
) -> FloatArray:
    """A covariance whose lines scatter by `scale` times the variance; what is known beforehand stays."""
    known = np.diag(prior)
    known[len(known) - len(stiff) :, len(known) - len(stiff) :] += stiff
    told = np.linalg.inv(covariance) - known
    return np.asarray(np.linalg.inv(told / scale + known), np.float64)


def _lost(kept: FloatArray) -> float:
    return -float(np.log(median(np.sort(kept)[: max(3, len(kept) // 4)])))


def _leverage_ev(lines: PlotLines, which: IntArray) -> float:
    """The widest range of upper levels (eV, ionisation counted) within one element."""
    a = atoms()
    energy = lines.e_k_ev + np.where(lines.ion, a.limit_ev[lines.element], 0.0)
    return widest(energy, which, int(which.max()) + 1)
