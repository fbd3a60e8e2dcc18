"""Temperature and density of the plasma from all lines of all elements in one Saha-Boltzmann plot.

ln(area) of each line is a straight function of 1/T (Boltzmann), of ln n_e where it is an ion's
(Saha), of its element's amount, and bends where the line absorbs itself (curve of growth, one
constant for the spectrum). All are fitted together, outliers down-weighted (Yalcin et al., Appl.
Phys. B 68, 121 (1999) for the plot; Aguilera and Aragon, Spectrochim. Acta B 62, 378 (2007) for
many elements in one).
"""

from dataclasses import dataclass, replace

import numpy as np

from ..spectrum.spectrum import FloatArray, IntArray
from .growth import growth_table, log_depth_of_unit
from .plot_fit import COOLEST_K, HOTTEST_K, LEAST_LN_NE, MOST_LN_NE, gauss_newton, trust
from .strengths import GRID_K, atoms, log_strengths

USUAL_K, USUAL_SPREAD = 10_500.0, 0.35  # of ln T, where the lines do not tell
USUAL_LOG_NE, USUAL_NE_SPREAD = float(np.log(8e16)), 1.2
CALIBRATION = 0.08  # of ln(area): efficiency, background, the model itself
STEPS = 10
LEAST_LINES = 4
LEAST_SPREAD_EV = 0.8


@dataclass(frozen=True, slots=True, eq=False)
class PlotLines:
    """Lines for the plot; rows are one line (or unresolved multiplet) each, shape (n,).

    log_area, error: ln counts nm. element: index. rows, entry: rows of the line table and the
    line that each belongs to. vacuum_nm, width_nm (at 1e17 per cm3), e_k_ev, ion: of the leader.
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

    def __len__(self) -> int:
        return len(self.log_area)

    def thin(self, temperature_k: float, density_per_cm3: float) -> FloatArray:
        """ln of the thin area for one atom of the element, shape (n,)."""
        log = log_strengths(self.rows, temperature_k, density_per_cm3)
        top = float(log.max(initial=0.0))
        return np.log(np.bincount(self.entry, np.exp(log - top), len(self)) + 1e-300) + top


@dataclass(frozen=True, slots=True, eq=False)
class Plot:
    """The fitted plot. Errors are standard errors, scaled by chi2 where that exceeds 1.

    log_opacity: the constant of the spectrum (see growth). log_scale: ln of each element's amount,
    shape (e,), NaN where it has no line. kept: part of its light that each line kept. residual:
    ln(area) minus the model. flags: warnings for the user.
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


def fit_plot(
    lines: PlotLines,
    density: Known | None = None,
    start_k: float = USUAL_K,
    most_steps: int = STEPS,
) -> Plot | None:
    """Fit the plot; None if the lines do not determine a temperature.

    density: ln n_e (per cm3) from elsewhere, such as the width of H-alpha.
    """
    if len(lines) < LEAST_LINES:
        return None
    names, which = np.unique(lines.element, return_inverse=True)
    density = density or Known(USUAL_LOG_NE, USUAL_NE_SPREAD)
    p, toward, prior = _start(lines, which, density, start_k)
    n = len(lines)
    thin, kept, residual, weight = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    sigma = np.sqrt(lines.error**2 + CALIBRATION**2)
    a = atoms()
    variance = gauss_newton(
        p,
        (lines.log_area, sigma, which, lines.ion.astype(np.int64), lines.e_k_ev, lines.vacuum_nm,
         lines.width_nm),
        _rows(lines, which),
        names,
        (a.log_u, GRID_K, a.limit_ev, growth_table()),
        toward, prior, most_steps, thin, kept, residual, weight, np.zeros((len(p), len(p))),
    )  # fmt: skip
    return _as_plot(p, variance, kept, residual, sigma, lines, names, which)


def _rows(lines: PlotLines, which: IntArray):
    a = atoms()
    return (
        lines.entry, which[lines.entry], a.ion[lines.rows].astype(np.int64), a.log_ga[lines.rows],
        a.e_k_ev[lines.rows],
    )  # fmt: skip


def _start(lines: PlotLines, which: IntArray, density: Known, start_k: float):
    """Initial parameters, their priors, and the priors' weights (1 / variance)."""
    ne = float(np.exp(density.mean))
    thin = lines.thin(start_k, ne)
    scale = np.bincount(which, lines.log_area - thin) / np.bincount(which)
    depth = log_depth_of_unit(lines.vacuum_nm, lines.width_nm * ne / 1e17, start_k)
    opacity = np.log(0.5) - np.max(thin + scale[which] + depth)
    p = np.concatenate([[np.log(start_k), density.mean, opacity], scale])
    toward, prior = p.copy(), np.zeros(len(p))
    toward[:2] = np.log(USUAL_K), density.mean
    prior[:3] = 1 / USUAL_SPREAD**2, 1 / density.spread**2, 0.05
    return p, toward, prior


def _as_plot(p, variance, kept, residual, sigma, lines, names, which) -> Plot:
    say = trust(residual / sigma)
    free = max(float(say.sum()) - len(p) + 1.0, 1.0)  # the priors know one of the parameters
    chi2 = float(np.sum(say * (residual / sigma) ** 2) / free)
    error = np.sqrt(np.maximum(variance, 0.0) * max(chi2, 1.0))
    scale = np.full(len(atoms().elements), np.nan)
    scale[names] = p[3:]
    part = np.exp(kept)
    kelvin = float(np.exp(p[0]))
    flags = []
    if _leverage_ev(lines, which) < LEAST_SPREAD_EV:
        flags.append("upper levels lie close together")
    if np.min(part) < 0.7:
        flags.append("strong lines absorb themselves")
    plot = Plot(
        kelvin, kelvin * float(error[0]), float(p[1] / np.log(10)), float(error[1] / np.log(10)),
        float(p[2]), scale, part, residual, chi2, tuple(flags),
    )  # fmt: skip
    if plot.temperature_at_bound:
        flags.append("the lines do not tell the temperature")
    if plot.density_at_bound:
        flags.append("the lines do not tell the density")
    return replace(plot, flags=tuple(flags))


def _leverage_ev(lines: PlotLines, which: IntArray) -> float:
    """The widest range of upper levels (eV, ionisation counted) within one element."""
    a = atoms()
    energy = lines.e_k_ev + np.where(lines.ion, a.limit_ev[lines.element], 0.0)
    return max(
        (float(np.ptp(energy[which == k])) for k in range(int(which.max(initial=-1)) + 1)),
        default=0.0,
    )
