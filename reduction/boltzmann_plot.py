"""Points of the Boltzmann and the Saha-Boltzmann plot, with errors, ready to be drawn or fitted.

Boltzmann: y = ln(area lambda / (g_k A_ki)) against E_k lies on a line of slope -1 / kT for each
species. Saha-Boltzmann: ions are shifted by their ionisation energy, and lowered by
ln(2 (2 pi m k T / h^2)^(3/2) / n_e), and come to lie on the line of their atoms (Yalcin et al.,
Appl. Phys. B 68, 121 (1999); Aguilera and Aragon, Spectrochim. Acta B 62, 378 (2007)).
"""

from dataclasses import dataclass

import numpy as np

from .boltzmann import CALIBRATION, Plot, PlotLines
from .lines import BOLTZMANN_EV_PER_K, LOWERING_EV
from .plasma import SAHA_PER_CM3
from .spectrum import FloatArray, TextArray
from .strengths import atoms, log_strengths

FAR_OUT = 2.5  # errors, beyond which a line is not believed


@dataclass(frozen=True, slots=True)
class BoltzmannFit:
    """The line through a Boltzmann plot: ln(area lambda / gA) = intercept - E / kT.

    Standard errors, scaled by chi2 (per degree of freedom) where that exceeds 1.
    """

    temperature_k: float
    temperature_error_k: float
    intercept: float
    intercept_error: float
    chi2: float

    def at(self, energy_ev: FloatArray) -> FloatArray:
        """y of the line at energies in eV, any shape."""
        return self.intercept - energy_ev / (BOLTZMANN_EV_PER_K * self.temperature_k)


def boltzmann_y(
    area: FloatArray, area_error: FloatArray, wavelength_nm: FloatArray, g_k: FloatArray,
    a_ki_per_s: FloatArray,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """ln(area lambda / (g_k A_ki)) of lines and its standard error; all of shape (n,)."""
    return np.log(area * wavelength_nm / (g_k * a_ki_per_s)), area_error / area


def boltzmann_fit(energy_ev: FloatArray, y: FloatArray, y_error: FloatArray) -> BoltzmannFit | None:
    """The weighted straight line through a Boltzmann plot of one species; shapes (n,).

    None for fewer than two levels, and where the line rises (no temperature does that).
    """
    if len(y) < 2 or np.ptp(energy_ev) <= 0:
        return None
    weight = 1.0 / np.asarray(y_error) ** 2
    middle, height = np.average(energy_ev, weights=weight), np.average(y, weights=weight)
    away = energy_ev - middle
    spread = float(np.sum(weight * away**2))
    slope = float(np.sum(weight * away * (y - height))) / spread
    if slope >= 0:
        return None
    left = y - height - slope * away
    chi2 = float(np.sum(weight * left**2)) / max(len(y) - 2, 1)
    scale = max(chi2, 1.0) if len(y) > 2 else 1.0
    slope_error = float(np.sqrt(scale / spread))
    kelvin = -1.0 / (BOLTZMANN_EV_PER_K * slope)
    error = float(np.hypot(np.sqrt(scale / np.sum(weight)), middle * slope_error))
    return BoltzmannFit(
        kelvin, kelvin * slope_error / -slope, float(height - slope * middle), error, chi2
    )


@dataclass(frozen=True, slots=True, eq=False)
class SahaBoltzmannPoints:
    """The plot of all elements at once; arrays of one line each, shape (n,).

    energy_ev: of the upper level, ionisation added for ions. y: corrected for self-absorption and
    for the element's amount, so that all lie on y = -energy / kT. y_error: of the area and of the
    transition probability. outlier: lines that the fit did not believe.
    """

    energy_ev: FloatArray
    y: FloatArray
    y_error: FloatArray
    element: TextArray
    ion: np.ndarray
    vacuum_nm: FloatArray
    kept: FloatArray
    outlier: np.ndarray
    temperature_k: float
    temperature_error_k: float

    def line(self, energy_ev: FloatArray) -> FloatArray:
        """y of the fitted line at energies in eV, any shape."""
        return -np.asarray(energy_ev) / (BOLTZMANN_EV_PER_K * self.temperature_k)

    def limits(self, energy_ev: FloatArray) -> tuple[FloatArray, FloatArray]:
        """y of the line one standard error of the temperature cooler, and hotter; any shape."""
        factor = self.temperature_error_k / self.temperature_k
        y = self.line(energy_ev)
        return y / (1.0 - factor), y / (1.0 + factor)


def saha_boltzmann_points(lines: PlotLines, plot: Plot) -> SahaBoltzmannPoints:
    """Points of the plot that was fitted by `fit_plot` to these lines."""
    a = atoms()
    kt = BOLTZMANN_EV_PER_K * plot.temperature_k
    shift = np.where(lines.ion, a.limit_ev[lines.element] - LOWERING_EV, 0.0)
    energy = lines.e_k_ev + shift
    y = plot.residual - energy / kt
    sigma = np.hypot(lines.error, CALIBRATION)
    return SahaBoltzmannPoints(
        energy, y, sigma, a.elements[lines.element], lines.ion, lines.vacuum_nm, plot.kept,
        np.abs(plot.residual) > FAR_OUT * sigma, plot.temperature_k, plot.temperature_error_k,
    )  # fmt: skip


def boltzmann_points(
    lines: PlotLines, plot: Plot | None, element: str, ion: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Upper level (eV), ln(area lambda / gA) and its error of one species' lines; shapes (k,).

    Corrected for self-absorption where a plot tells it. What several rows of the table make
    together counts with their summed strength.
    """
    a = atoms()
    own = np.flatnonzero((a.elements[lines.element] == element) & (lines.ion == ion))
    kelvin = 10_000.0 if plot is None else plot.temperature_k
    kt = BOLTZMANN_EV_PER_K * kelvin
    log_ga = np.full(len(lines), -np.inf)
    excess = lines.e_k_ev[lines.entry] - a.e_k_ev[lines.rows]
    np.logaddexp.at(log_ga, lines.entry, a.log_ga[lines.rows] + excess / kt)
    kept = 0.0 if plot is None else np.log(plot.kept[own])
    return lines.e_k_ev[own], lines.log_area[own] - kept - log_ga[own], lines.error[own]


def saha_shift(temperature_k: float, density_per_cm3: float) -> float:
    """How much lower an ion's point is drawn: ln(4.829e15 T^1.5 / n_e), no unit."""
    return float(np.log(SAHA_PER_CM3 * temperature_k**1.5 / density_per_cm3))


def amounts(lines: PlotLines, plot: Plot, temperature_k: float, density_per_cm3: float):
    """ln of the atoms of each element of the plot (arbitrary unit), and their indices, (k,).

    What each line kept is that of the plot; lines that the fit did not believe have no say.
    """
    names, which = np.unique(lines.element, return_inverse=True)
    log = log_strengths(lines.rows, temperature_k, density_per_cm3)
    thin = np.full(len(lines), -np.inf)
    np.logaddexp.at(thin, lines.entry, log)
    sigma = np.hypot(lines.error, CALIBRATION)
    weight = 1.0 / sigma**2 / (1.0 + (plot.residual / (FAR_OUT * sigma)) ** 2) ** 2
    each = lines.log_area - np.log(plot.kept) - thin
    return np.bincount(which, weight * each) / np.bincount(which, weight), names
