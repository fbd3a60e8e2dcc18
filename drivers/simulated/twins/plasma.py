"""A laser plasma in local thermal equilibrium, and the light it gives.

Level populations after Boltzmann, stages after Saha, line shapes after Voigt (Stark width and
slit), strong lines that absorb their own light in a uniform slab, bremsstrahlung and recombination
below all of it. Intensities are energies, so the Boltzmann plot is ln(I lambda / g A).
"""

from dataclasses import dataclass

import numpy as np

from . import instrument
from .atoms import Lines, read_atoms
from .lines import StrongLines, WeakLines
from .minerals import ELEMENTS, MINERALS, atom_fractions

EV_NM = 1239.841984
SAHA_PER_CM3 = 6.0371e21  # 2 (2 pi m k T / h^2)^1.5 at kT = 1 eV
# lambda^4 A g / (8 pi c): wavelengths in nm, the rest in cm and s, the result times nm.
ABSORPTION = 1e-21 / (8 * np.pi * 2.99792458e10)
ATOMS_PER_CM3 = 2.0e17
DEPTH_CM = 0.03
# Argon flushes the chamber, and some of it is in the plasma; so is the rest of the room's air.
AMBIENT = {"Ar": 0.06, "H": 0.006}
PLASMA_ELEMENTS = tuple(sorted({*ELEMENTS, *AMBIENT}))
BRIGHTNESS = 3.0e-14  # counts nm for the light that the spectrometer sees
CONTINUUM = 250.0  # counts at 500 nm, 1 eV and 1e17 electrons/cm3
GRID_EV = np.linspace(0.5, 1.6, 56)
NOTICED = 0.5  # counts that a line must have at its peak in some mineral
STRONG_DEPTH, STRONG_COUNTS, STRONG_WIDTH_NM = 0.03, 2500.0, 0.35


@dataclass(frozen=True, slots=True)
class State:
    """What one shot made: temperature in eV, electrons in 1/cm3, and how much there is of it."""

    temperature_ev: float = 1.0
    electrons_per_cm3: float = 1e17
    amount: float = 1.0


def spark(random: np.random.Generator) -> State:
    """One shot's plasma; no two are alike."""
    jitter = random.standard_normal(3)
    temperature = float(np.clip(1.03 + 0.02 * jitter[0], 0.9, 1.1))
    return State(
        temperature, float(1e17 * np.exp(0.08 * jitter[1])), float(np.exp(0.06 * jitter[2]))
    )


class Plasma:
    """Light of any mixture of the elements; made once, it takes milliseconds a shot."""

    def __init__(self) -> None:
        self.species, lines = read_atoms(PLASMA_ELEMENTS)
        self.partition = np.array(
            [np.exp(-s.level_ev / GRID_EV[:, None]) @ s.level_g for s in self.species]
        )
        self.neutral_ev = np.array([s.ionisation_ev for s in self.species[::2]])
        self.places = np.array([PLASMA_ELEMENTS.index(element) for element in ELEMENTS])
        self.ambient = np.array([AMBIENT.get(element, 0.0) for element in PLASMA_ELEMENTS])
        self.axis = instrument.axis()
        counts, depth = self._extremes(lines)
        strong = (depth > STRONG_DEPTH) | (counts > STRONG_COUNTS)
        strong |= (lines.stark_nm > STRONG_WIDTH_NM) & (counts > 20)
        self.weak = WeakLines(lines.where(~strong & (counts > NOTICED)))
        self.strong = StrongLines(lines.where(strong & (counts > NOTICED)))

    def light(self, atoms: np.ndarray, state: State) -> np.ndarray:
        """What falls on every channel, in counts, before the detector adds its noise."""
        densities = self.densities(atoms, state)
        spectrum = self._continuum(state)
        weak = self.weak.lines
        spectrum += self.weak.shine(_emission(weak, densities, state))
        strong = self.strong.lines
        spectrum += self.strong.shine(
            _emission(strong, densities, state),
            _absorption(strong, densities, state),
            strong.stark_nm * state.electrons_per_cm3 / 1e17,
        )
        return spectrum

    def densities(self, atoms: np.ndarray, state: State) -> np.ndarray:
        """Density of each species over its partition function, 1/cm3.

        `atoms` are shares in the order of minerals.ELEMENTS; what the chamber adds comes on top.
        """
        mixture = self.ambient.copy()
        mixture[self.places] += (1 - self.ambient.sum()) * atoms
        kt = state.temperature_ev
        sums = np.array([np.interp(kt, GRID_EV, row) for row in self.partition])
        # n_II n_e / n_I = 2 (2 pi m k T / h^2)^1.5 U_II / U_I exp(-E / kT)
        ratio = SAHA_PER_CM3 * kt**1.5 / state.electrons_per_cm3 * sums[1::2] / sums[::2]
        ratio = ratio * np.exp(-self.neutral_ev / kt)
        neutral = mixture * ATOMS_PER_CM3 * state.amount / (1 + ratio)
        return np.stack([neutral, neutral * ratio], axis=1).ravel() / sums

    def _continuum(self, state: State) -> np.ndarray:
        """Bremsstrahlung and recombination, as far as the optics let them through."""
        photon = EV_NM / self.axis / state.temperature_ev
        free = (500.0 / self.axis) ** 2 * (np.exp(-photon) + 1.3 * (1 - np.exp(-photon)))
        passed = 1 / (1 + np.exp((250.0 - self.axis) / 25)) / (1 + np.exp((self.axis - 980.0) / 60))
        dense = state.amount * (state.electrons_per_cm3 / 1e17) ** 2 / np.sqrt(state.temperature_ev)
        return CONTINUUM * dense * free * passed

    def _extremes(self, lines: Lines) -> tuple[np.ndarray, np.ndarray]:
        """Counts and optical depth that each line's peak has at most, over all minerals."""
        counts, depth = np.zeros(len(lines)), np.zeros(len(lines))
        for mineral in MINERALS:
            shares = atom_fractions(mineral.name)
            atoms = np.array([shares.get(element, 0.0) for element in ELEMENTS])
            for state in (State(0.9), State(1.1)):
                densities = self.densities(atoms, state)
                width = 1.06 * np.hypot(lines.stark_nm, instrument.SLIT_NM)
                counts = np.maximum(counts, _emission(lines, densities, state) / width)
                peak = 2 / (np.pi * np.maximum(lines.stark_nm, 0.012))
                depth = np.maximum(depth, _absorption(lines, densities, state) * peak)
        return counts, depth


def _emission(lines: Lines, densities: np.ndarray, state: State) -> np.ndarray:
    """Energy of each line from a thin plasma, counts nm."""
    population = densities[lines.species] * np.exp(-lines.upper_ev / state.temperature_ev)
    return BRIGHTNESS * DEPTH_CM * lines.weight * population / lines.wavelength_nm


def _absorption(lines: Lines, densities: np.ndarray, state: State) -> np.ndarray:
    """Optical depth of each line times nm: the depth at a place is this by the profile there."""
    kt = state.temperature_ev
    lower = densities[lines.species] * np.exp(-lines.lower_ev / kt)
    stimulated = 1 - np.exp(-EV_NM / lines.wavelength_nm / kt)
    return ABSORPTION * lines.wavelength_nm**4 * lines.weight * lower * stimulated * DEPTH_CM
