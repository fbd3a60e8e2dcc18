"""Lines and levels as the generator sees them; sums over states from SI constants."""

from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from io import BytesIO

import numpy as np
from scipy import constants as si

EV_K = si.e / si.k  # kelvin in an electronvolt
PER_CM3 = 1e-6
# What NIST's accuracy class allows a transition probability to be off, as a part of it.
CLASS = {
    "AAA": 0.003, "AA": 0.01, "A+": 0.02, "A": 0.03, "B+": 0.07, "B": 0.10, "C+": 0.18,
    "C": 0.25, "D+": 0.40, "D": 0.50, "E": 0.7,
}  # fmt: skip


@dataclass(frozen=True)
class Lines:
    """Rows of one line each, ascending in vacuum wavelength (nm); energies in eV."""

    element: np.ndarray
    stage: np.ndarray
    nm: np.ndarray
    ga: np.ndarray
    low_ev: np.ndarray
    high_ev: np.ndarray
    stark_nm: np.ndarray  # full width at 1e17 electrons per cm3
    uncertain: np.ndarray

    def where(self, chosen: np.ndarray) -> "Lines":
        return Lines(*(value[chosen] for value in vars(self).values()))


@cache
def table() -> dict[str, np.ndarray]:
    packed = files("labrun.reduction.data").joinpath("lines.npz").read_bytes()
    with np.load(BytesIO(packed), allow_pickle=False) as arrays:
        return {name: arrays[name] for name in arrays.files}


@cache
def lines_of(elements: tuple[str, ...]) -> Lines:
    t = table()
    rows = np.isin(t["element"], elements)
    stark = 10 ** (t["stark_a"][rows] @ np.array([1.0, 4.0, 16.0])) / 10
    stark = stark * 1e17 / t["stark_density_per_cm3"][rows]
    guess = hydrogenic_width(t, rows)
    uncertain = np.array([CLASS.get(name.rstrip("'"), 0.5) for name in t["accuracy"][rows]])
    return Lines(
        t["element"][rows],
        t["stage"][rows].astype(int),
        t["wavelength_nm"][rows],
        t["g_k"][rows] * t["a_ki_per_s"][rows],
        t["e_i_ev"][rows],
        t["e_k_ev"][rows],
        np.where(np.isnan(stark), guess, stark),
        uncertain,
    )


def hydrogenic_width(t: dict[str, np.ndarray], rows: np.ndarray) -> np.ndarray:
    """A width for lines without one: the square of the upper orbit, scattered by a third.

    The scatter belongs to the line (its wavelength seeds it), so that no smooth rule has it.
    """
    limit = np.array(
        [
            ionisation_ev(str(e), int(s))
            for e, s in zip(t["element"][rows], t["stage"][rows], strict=True)
        ]
    )
    orbit = 13.606 * t["stage"][rows] ** 2 / np.maximum(limit - t["e_k_ev"][rows], 0.2)
    nm = t["wavelength_nm"][rows]
    scatter = np.exp(0.35 * np.sin(nm * 12_345.678))
    width = 0.016 * (nm / 500) ** 2 * (orbit / 5) ** 1.6 / t["stage"][rows] ** 2 * scatter
    return np.clip(width, 0.002, 1.5)


@cache
def _species(element: str, stage: int) -> tuple[float, np.ndarray, np.ndarray]:
    t = table()
    found = np.flatnonzero((t["species_element"] == element) & (t["species_stage"] == stage))
    if not len(found):
        return np.inf, np.zeros(1), np.ones(1)
    levels = slice(t["level_offset"][found[0]], t["level_offset"][found[0] + 1])
    return float(t["species_ionisation_ev"][found[0]]), t["level_ev"][levels], t["level_g"][levels]


def ionisation_ev(element: str, stage: int) -> float:
    return _species(element, stage)[0]


def partition(element: str, stage: int, kelvin: float) -> float:
    """Sum over the levels that stay bound in a dense plasma (0.1 eV below the limit)."""
    limit, energies, weights = _species(element, stage)
    bound = energies < limit - 0.1
    return float(np.dot(weights[bound], np.exp(-energies[bound] * EV_K / kelvin)))


def ions_per_atom(element: str, kelvin: float, electrons_cm3: float) -> float:
    """Saha's equation from the thermal wavelength of the electron."""
    thermal_m = si.h / np.sqrt(2 * np.pi * si.m_e * si.k * kelvin)
    states = 2 / (electrons_cm3 / PER_CM3 * thermal_m**3)
    ratio = partition(element, 2, kelvin) / partition(element, 1, kelvin)
    return float(states * ratio * np.exp(-ionisation_ev(element, 1) * EV_K / kelvin))
