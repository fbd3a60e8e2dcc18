"""Lines, levels and ionisation energies of the elements that a plasma holds.

The table lies with `reduction`, but it is data: the twins read it and know nothing of how a
spectrum is taken apart, so that neither can lean on the other's mistakes.
"""

from dataclasses import dataclass
from importlib.resources import files

import numpy as np

CLOSE_NM = 0.03  # nearer than this, lines from one lower level are one line (Li I 670.78)


@dataclass(frozen=True, slots=True, eq=False)
class Lines:
    """Arrays of one row a line, ascending in (vacuum) wavelength.

    `species` is the row's place in the list of species, `weight` is g_k A_ki in 1/s, `stark`
    the full width in nm at 1e17 electrons/cm3 and 1 eV.
    """

    species: np.ndarray
    wavelength_nm: np.ndarray
    weight: np.ndarray
    upper_ev: np.ndarray
    lower_ev: np.ndarray
    stark_nm: np.ndarray

    def __len__(self) -> int:
        return len(self.species)

    def where(self, chosen: np.ndarray) -> "Lines":
        """The rows that a mask or indices choose."""
        return Lines(*(getattr(self, name)[chosen] for name in Lines.__slots__))


@dataclass(frozen=True, slots=True, eq=False)
class Species:
    """One element in one stage (1 neutral, 2 ionised) and its levels below ionisation."""

    element: str
    stage: int
    ionisation_ev: float
    level_ev: np.ndarray
    level_g: np.ndarray


def read_atoms(elements: tuple[str, ...]) -> tuple[list[Species], Lines]:
    """Two species for each element, neutral then ionised, and all their lines."""
    with files("labrun.reduction.data").joinpath("lines.npz").open("rb") as file:
        table = dict(np.load(file, allow_pickle=False))
    species = [_species(table, element, stage) for element in elements for stage in (1, 2)]
    return species, _one_line(_lines(table, elements, species))


def _species(table: dict[str, np.ndarray], element: str, stage: int) -> Species:
    found = np.flatnonzero(
        (table["species_element"] == element) & (table["species_stage"] == stage)
    )
    if not len(found):  # a bare nucleus, or an ion without known lines
        return Species(element, stage, np.inf, np.zeros(1), np.ones(1))
    begin, end = table["level_offset"][found[0] : found[0] + 2]
    energies, limit = table["level_ev"][begin:end], float(table["species_ionisation_ev"][found[0]])
    bound = energies < limit
    return Species(element, stage, limit, energies[bound], table["level_g"][begin:end][bound])


def _lines(
    table: dict[str, np.ndarray], elements: tuple[str, ...], species: list[Species]
) -> Lines:
    chosen = np.isin(table["element"], elements)
    row = {name: array[chosen] for name, array in table.items() if len(array) == len(chosen)}
    index = np.searchsorted(elements, row["element"]) * 2 + row["stage"] - 1
    wavelength = row["wavelength_nm"]
    limits = np.array([s.ionisation_ev for s in species])[index]
    temperature = np.log10(1.0 / 8.617333262e-5)
    known = 10 ** (row["stark_a"] @ np.array([1.0, temperature, temperature**2])) / 10
    known = known * 1e17 / row["stark_density_per_cm3"]
    guessed = _stark_guess(wavelength, row["stage"], limits - row["e_k_ev"])
    stark = np.where(np.isnan(known), guessed, known)
    # Hydrogen feels the field itself: Gigosos et al., Spectrochim. Acta B 58, 1489 (2003).
    for centre, width in ((656.46, 1.098), (486.27, 4.80), (434.17, 4.9), (410.29, 7.0)):
        stark = np.where((row["element"] == "H") & (abs(wavelength - centre) < 0.1), width, stark)
    weight = row["g_k"] * row["a_ki_per_s"]
    return Lines(index, wavelength, weight, row["e_k_ev"], row["e_i_ev"], np.minimum(stark, 8.0))


def _stark_guess(wavelength: np.ndarray, stage: np.ndarray, gap_ev: np.ndarray) -> np.ndarray:
    """A width for lines that were never measured: it grows as the upper orbit squared."""
    orbit = 13.606 * stage**2 / np.maximum(gap_ev, 0.15)  # n* squared
    return np.minimum(0.012 * (wavelength / 500) ** 2 * (orbit / stage) ** 2 / 30, 1.5)


def _one_line(lines: Lines) -> Lines:
    """Fine structure that no spectrometer parts, from one lower level, made one line.

    Otherwise each part would absorb only its own light, and the sum would be too bright.
    """
    order = np.lexsort((lines.wavelength_nm, np.round(lines.lower_ev, 2), lines.species))
    sorted_ = lines.where(order)
    same = (np.diff(sorted_.species) == 0) & (np.diff(sorted_.wavelength_nm) < CLOSE_NM)
    same &= np.diff(np.round(sorted_.lower_ev, 2)) == 0
    begins = np.flatnonzero(np.concatenate([[True], ~same]))
    total = np.add.reduceat(sorted_.weight, begins)
    centre = np.add.reduceat(sorted_.weight * sorted_.wavelength_nm, begins) / total
    upper = np.add.reduceat(sorted_.weight * sorted_.upper_ev, begins) / total
    first = sorted_.where(begins)
    merged = Lines(first.species, centre, total, upper, first.lower_ev, first.stark_nm)
    return merged.where(np.argsort(merged.wavelength_nm))
