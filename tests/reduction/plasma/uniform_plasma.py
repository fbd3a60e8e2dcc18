"""Lines of a uniform plasma, for the tests that fit its plot."""

import numpy as np

from labrun.reduction.plasma.boltzmann import PlotLines
from labrun.reduction.plasma.growth import log_depth_of_unit, log_kept
from labrun.reduction.plasma.strengths import atoms, log_strengths


def lines_at(kelvin, log_ne, log_opacity=-60.0, noise=0.03, seed=0, elements=("Si", "Fe", "Mg")):
    """Bright lines of a few elements with the areas of a uniform plasma."""
    a, rng = atoms(), np.random.default_rng(seed)
    rows = []
    for symbol in elements:
        for ion in (False, True):
            own = np.flatnonzero((a.elements[a.element] == symbol) & (a.ion == ion))
            rows.append(own[np.argsort(-log_strengths(own, kelvin, 10**log_ne))[:25]])
    rows = np.concatenate(rows)
    thin = log_strengths(rows, kelvin, 10**log_ne)
    width = a.width_nm[rows] * 10 ** (log_ne - 17)
    log_tau = log_opacity + thin + log_depth_of_unit(a.wavelength_nm[rows], width, kelvin)
    area = thin + log_kept(log_tau) + noise * rng.standard_normal(len(rows))
    return PlotLines(
        area, np.full(len(rows), noise), a.element[rows], rows, np.arange(len(rows)),
        a.wavelength_nm[rows], a.width_nm[rows], a.e_k_ev[rows], a.ion[rows], np.full(len(rows), noise),
    )  # fmt: skip
