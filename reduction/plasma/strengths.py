"""Strengths of all lines of the table at once, at any temperature and density.

Local thermodynamic equilibrium, optically thin, energies: area ~ share of the stage * g_k A_ki /
(U lambda) * exp(-E_k / kT), the stages after Saha (Griem, Plasma Spectroscopy, 1964). The sums
over states are tabulated once on a grid of temperatures and read off it in logarithms.
"""

from dataclasses import dataclass

import numpy as np

from ..lines.lines import (
    BOLTZMANN_EV_PER_K,
    LOWERING_EV,
    line_table,
    of_lines,
    partition_function,
    species,
)
from ..spectrum.spectrum import FloatArray, IntArray, TextArray
from .plasma import SAHA_PER_CM3

GRID_K = np.arange(4_000.0, 20_001.0, 400.0)
# Where no width is known: least squares through the 1,745 widths of STARK-B below 3 nm, in which
# they scatter by a factor of three (I) and two (II). Full width in nm at 500 nm, 1e17 electrons per
# cm3, and an upper orbit of n*^2 = 5; it grows as wavelength squared and orbit to the power.
GUESSED_WIDTH_NM = {1: 0.053, 2: 0.026}
ORBIT_POWER = 1.7


@dataclass(frozen=True, slots=True, eq=False)
class Atoms:
    """The line table with what the strengths need beside it.

    elements: symbols, shape (e,). element: which of them each line is of, shape (n,); ion: True
    for stage II; species: element, plus e for an ion. log_ga: ln(g_k A_ki / lambda). log_u: ln U,
    shape (e, 2, GRID_K). limit_ev: ionisation energy of the atom, shape (e,). width_nm: full Stark
    width at 1e17 per cm3.
    uncertainty: of ln A, from NIST's accuracy class.
    """

    elements: TextArray
    element: IntArray
    species: IntArray
    ion: np.ndarray
    wavelength_nm: FloatArray
    log_ga: FloatArray
    e_i_ev: FloatArray
    e_k_ev: FloatArray
    log_u: FloatArray
    limit_ev: FloatArray
    width_nm: FloatArray
    uncertainty: FloatArray


# NIST's classes: the transition probability is right to this part (nist.gov, ASD help, table of
# accuracy), here as a standard deviation of its logarithm.
CLASS = {
    "AAA": 0.003, "AA": 0.01, "A+": 0.02, "A": 0.03, "B+": 0.07, "B": 0.1, "C+": 0.18, "C": 0.25,
    "D+": 0.4, "D": 0.5, "E": 0.7,
}  # fmt: skip


@of_lines()
def atoms() -> Atoms:
    """The whole table, prepared once."""
    table = line_table()
    elements, element = np.unique(table.element, return_inverse=True)
    log_u = np.zeros((len(elements), 2, len(GRID_K)))
    for e, symbol in enumerate(elements.tolist()):
        for stage in (1, 2):
            if symbol == "H" and stage == 2:
                continue  # a bare proton: U = 1
            log_u[e, stage - 1] = np.log(partition_function(symbol, stage, GRID_K))
    limit = np.array([species(symbol, 1).ionisation_ev for symbol in elements.tolist()])
    known = table.stark_fwhm_nm(10_000.0, 1e17)
    return Atoms(
        elements,
        element,
        element + len(elements) * (table.stage == 2),
        table.stage == 2,
        table.wavelength_nm.copy(),  # a loop is compiled once more for what cannot be written to
        np.log(table.g_k * table.a_ki_per_s / table.wavelength_nm),
        table.e_i_ev,
        table.e_k_ev.copy(),
        log_u,
        limit,
        np.where(np.isnan(known), _guessed_width(elements, element), known),
        np.array([CLASS.get(name.rstrip("'"), 0.5) for name in table.accuracy.tolist()]),
    )


def present(element: IntArray) -> tuple[IntArray, IntArray]:
    """The elements among some indices of elements (any number), ascending, and which of them each is."""
    there = np.zeros(len(atoms().elements), np.bool_)
    there[element] = True
    return np.flatnonzero(there), (np.cumsum(there) - 1)[element]


def _guessed_width(elements: TextArray, element: IntArray) -> FloatArray:
    table = line_table()
    limits = np.array([
        [species(symbol, stage).ionisation_ev if (symbol, stage) != ("H", 2) else 13.6
         for stage in (1, 2)]
        for symbol in elements.tolist()
    ])  # fmt: skip
    gap = np.maximum(limits[element, table.stage - 1] - table.e_k_ev, 0.2)
    orbit = 13.606 * table.stage**2 / gap
    at_500 = np.where(table.stage == 1, GUESSED_WIDTH_NM[1], GUESSED_WIDTH_NM[2])
    width = at_500 * (table.wavelength_nm / 500) ** 2 * (orbit / 5) ** ORBIT_POWER
    return np.clip(width, 0.003, 1.5)


def _log_saha(
    log_u: FloatArray, temperature_k: FloatArray, density_per_cm3: FloatArray
) -> FloatArray:
    """ln of ions per atom, shape (..., e), of temperatures and densities (..., 1)."""
    return (
        np.log(SAHA_PER_CM3 / density_per_cm3)
        + 1.5 * np.log(temperature_k)
        + log_u[..., 1]
        - log_u[..., 0]
        - (atoms().limit_ev - LOWERING_EV) / (BOLTZMANN_EV_PER_K * temperature_k)
    )


def log_strengths(
    rows: IntArray, temperature_k: float | FloatArray, density_per_cm3: float | FloatArray
) -> FloatArray:
    """ln of the thin area for one atom of its element, arbitrary unit, of the table's rows; shape (..., rows)
    for temperatures and densities (...)."""
    a = atoms()
    held, inverse = held_by_states(temperature_k, density_per_cm3)
    return a.log_ga[rows] + held[..., a.species[rows]] + inverse * a.e_k_ev[rows]


def held_by_states(
    temperature_k: float | FloatArray, density_per_cm3: float | FloatArray
) -> tuple[FloatArray, FloatArray]:
    """ln of an atom's share of a state of g = 1 at 0 eV, by species, (..., 2 e), and -1 / kT, (..., 1)."""
    kelvin, density = np.asarray(temperature_k)[..., None], np.asarray(density_per_cm3)[..., None]
    log_u = _log_u(kelvin[..., 0])
    log_ratio = _log_saha(log_u, kelvin, density)
    neutral = -np.logaddexp(0.0, log_ratio)
    held = np.concatenate([neutral - log_u[..., 0], neutral + log_ratio - log_u[..., 1]], axis=-1)
    return held, -1.0 / (BOLTZMANN_EV_PER_K * kelvin)


@of_lines()
def _by_temperature() -> FloatArray:
    return np.ascontiguousarray(np.moveaxis(atoms().log_u, -1, 0))


def _log_u(temperature_k: FloatArray) -> FloatArray:
    """ln U of all species at temperatures (...), shape (..., e, 2)."""
    place = (temperature_k - GRID_K[0]) / (GRID_K[1] - GRID_K[0])
    place = np.minimum(np.maximum(place, 0.0), len(GRID_K) - 1.001)
    i = place.astype(int)
    table, far = _by_temperature(), (place - i)[..., None, None]
    return table[i] + far * (table[i + 1] - table[i])
