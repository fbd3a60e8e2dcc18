"""Temperature and density of the plasma from all lines of all elements in one Saha-Boltzmann plot.

ln(area) of each line is a straight function of 1/T (Boltzmann), of ln n_e where it is an ion's
(Saha), of its element's amount, and bends where the line absorbs itself (curve of growth, one
constant for the spectrum). All are fitted together, outliers weighed down (Yalcin et al., Appl.
Phys. B 68, 121 (1999) for the plot; Aguilera and Aragon, Spectrochim. Acta B 62, 378 (2007) for
many elements in one).
"""

from dataclasses import dataclass

import numpy as np

from .growth import log_depth_of_unit, log_kept, radiance_slope
from .spectrum import FloatArray, IntArray
from .strengths import atoms, log_slopes, log_strengths

USUAL_K, USUAL_SPREAD = 10_500.0, 0.35  # of ln T, where the lines do not tell
USUAL_LOG_NE, USUAL_NE_SPREAD = float(np.log(8e16)), 1.2
CALIBRATION = 0.08  # of ln(area): efficiency, background, the model itself
STEPS = 10
OUTLIER = 2.5
COOLEST_K, HOTTEST_K = 4_500.0, 19_000.0
THINNEST, THICKEST = -9.0, 7.0  # of ln tau of the strongest line
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
    ln(area) minus the model. flags: what a person should know.
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
    """Fit the plot; None where the lines cannot tell a temperature.

    density: ln n_e (per cm3) from elsewhere, such as the width of H-alpha.
    """
    if len(lines) < LEAST_LINES:
        return None
    names, which = np.unique(lines.element, return_inverse=True)
    density = density or Known(USUAL_LOG_NE, USUAL_NE_SPREAD)
    thin = lines.thin(start_k, float(np.exp(density.mean)))
    scale = np.bincount(which, lines.log_area - thin) / np.bincount(which)
    p = np.concatenate([[np.log(start_k), density.mean, 0.0], scale])
    p[2] = np.log(0.5) - np.max(_log_tau(p, lines, which, thin))
    p, normal, weight, residual = _gauss_newton(p, lines, which, density, most_steps)
    return _as_plot(p, normal, weight, residual, lines, names, which)


def _log_tau(p, lines, which, thin):
    width = lines.width_nm * np.exp(p[1]) / 1e17
    depth = log_depth_of_unit(lines.vacuum_nm, width, float(np.exp(p[0])))
    return p[2] + thin + p[3 + which] + depth


def _model(p, lines, which):
    """ln(area), and d ln f / d ln tau, of each line; the opacity in p is kept within bounds."""
    thin = lines.thin(float(np.exp(p[0])), float(np.exp(p[1])))
    log_tau = _log_tau(p, lines, which, thin)
    thickest = np.max(log_tau)
    beyond = np.clip(thickest, THINNEST, THICKEST) - thickest
    p[2] += beyond
    part, slope = log_kept(log_tau + beyond)
    return thin + p[3 + which] + part, slope


def _jacobian(p, lines, which, slope):
    n, kelvin = len(lines), float(np.exp(p[0]))
    heat, density = log_slopes(lines.element, lines.ion, lines.e_k_ev, kelvin, float(np.exp(p[1])))
    jacobian = np.zeros((n, len(p)))
    # The depth grows with the thin area, and shrinks with Planck's radiance and the Stark width.
    jacobian[:, 0] = heat + slope * (heat - radiance_slope(lines.vacuum_nm, kelvin))
    jacobian[:, 1] = density + slope * (density - 1.0)
    jacobian[:, 2] = slope
    jacobian[np.arange(n), 3 + which] = 1.0 + slope
    return jacobian


def _gauss_newton(p, lines, which, density, most_steps):
    prior = np.zeros(len(p))
    prior[:3] = 1 / USUAL_SPREAD**2, 1 / density.spread**2, 0.05
    toward = p.copy()
    toward[:2] = np.log(USUAL_K), density.mean
    sigma = np.sqrt(lines.error**2 + CALIBRATION**2)
    model, slope = _model(p, lines, which)
    normal = np.eye(len(p))
    for _ in range(most_steps):
        residual = lines.log_area - model
        weight = _trust(residual / sigma) / sigma**2
        jacobian = _jacobian(p, lines, which, slope)
        normal = (jacobian * weight[:, None]).T @ jacobian + np.diag(prior + 1e-9)
        gradient = jacobian.T @ (weight * residual) - prior * (p - toward)
        step = np.linalg.solve(normal, gradient)
        step[:3] = np.clip(step[:3], (-0.25, -1.0, -1.5), (0.25, 1.0, 1.5))
        p = p + step
        p[0] = np.clip(p[0], np.log(COOLEST_K), np.log(HOTTEST_K))
        p[1] = np.clip(p[1], np.log(1e15), np.log(3e18))
        model, slope = _model(p, lines, which)
        if np.max(np.abs(step[:2])) < 1e-3:
            break
    residual = lines.log_area - model
    weight = _trust(residual / sigma) / sigma**2
    return p, normal, weight, residual


def _trust(z):
    """Weights of Geman and McClure: an outlier loses its say."""
    return 1.0 / (1.0 + (z / OUTLIER) ** 2) ** 2


def _as_plot(p, normal, weight, residual, lines, names, which) -> Plot:
    covariance = np.linalg.inv(normal)
    trust = _trust(residual / np.sqrt(lines.error**2 + CALIBRATION**2))
    free = max(float(trust.sum()) - len(p) + 1.0, 1.0)  # the priors know one of the parameters
    chi2 = float(np.sum(weight * residual**2) / free)
    error = np.sqrt(np.maximum(np.diag(covariance), 0.0) * max(chi2, 1.0))
    scale = np.full(len(atoms().elements), np.nan)
    scale[names] = p[3:]
    thin = lines.thin(float(np.exp(p[0])), float(np.exp(p[1])))
    part = np.exp(log_kept(_log_tau(p, lines, which, thin))[0])
    kelvin = float(np.exp(p[0]))
    flags = []
    if _leverage_ev(lines, which) < LEAST_SPREAD_EV:
        flags.append("upper levels lie close together")
    if np.min(part) < 0.7:
        flags.append("strong lines absorb themselves")
    return Plot(
        kelvin, kelvin * float(error[0]), float(p[1] / np.log(10)), float(error[1] / np.log(10)),
        float(p[2]), scale, part, residual, chi2, tuple(flags),
    )  # fmt: skip


def _leverage_ev(lines: PlotLines, which: IntArray) -> float:
    """The widest range of upper levels (eV, ionisation counted) within one element."""
    a = atoms()
    energy = lines.e_k_ev + np.where(lines.ion, a.limit_ev[lines.element], 0.0)
    return max(
        (float(np.ptp(energy[which == k])) for k in range(int(which.max(initial=-1)) + 1)),
        default=0.0,
    )
