"""The minerals of a lithium pegmatite: formulas as atoms a formula unit, traces in ppm by mass.

Lepidolite stands between trilithionite and polylithionite, K Li1.7 Al1.9 Si3.4 O10.6 H0.6 F1.4.
Traces are typical of zoned lithium-caesium-tantalum pegmatites.
"""

from dataclasses import dataclass
from functools import cache

# Standard atomic weights, g/mol (IUPAC 2021, conventional values).
MASS = {
    "H": 1.008, "Li": 6.94, "O": 15.999, "F": 18.998, "Na": 22.990, "Mg": 24.305, "Al": 26.982,
    "Si": 28.085, "Ar": 39.95, "K": 39.098, "Ca": 40.078, "Ti": 47.867, "Mn": 54.938,
    "Fe": 55.845, "Rb": 85.468, "Cs": 132.905,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Mineral:
    """One mineral: what it is made of, and how it grows.

    `size` is its grains' size over the mean grain's, `stretch` their length over their width.
    """

    name: str
    atoms: dict[str, float]
    traces_ppm: dict[str, float]
    share: float
    size: float
    stretch: float


MINERALS = (
    Mineral(
        "spodumene", {"Li": 1, "Al": 1, "Si": 2, "O": 6},
        {"Fe": 4000, "Mn": 900, "Na": 700, "Ca": 150, "Mg": 60, "Ti": 40, "H": 60},
        share=0.24, size=1.25, stretch=2.4,
    ),
    Mineral(
        "quartz", {"Si": 1, "O": 2},
        {"Al": 120, "Na": 20, "Ca": 15, "Ti": 15, "H": 120},
        share=0.25, size=1.1, stretch=1.2,
    ),
    Mineral(
        "albite", {"Na": 1, "Al": 1, "Si": 3, "O": 8},
        {"Ca": 3500, "K": 1500, "Fe": 150, "H": 90},
        share=0.20, size=0.9, stretch=1.8,
    ),
    Mineral(
        "K-feldspar", {"K": 1, "Al": 1, "Si": 3, "O": 8},
        {"Rb": 3200, "Na": 9000, "Cs": 250, "Ca": 250, "Fe": 200, "H": 90},
        share=0.14, size=1.2, stretch=1.4,
    ),
    Mineral(
        "muscovite", {"K": 1, "Al": 3, "Si": 3, "O": 12, "H": 2},
        {"Rb": 2600, "Fe": 9000, "Na": 4200, "F": 2500, "Li": 250, "Mn": 700, "Mg": 1200,
         "Ti": 350},
        share=0.09, size=0.8, stretch=2.6,
    ),
    Mineral(
        "lepidolite", {"K": 1, "Li": 1.7, "Al": 1.9, "Si": 3.4, "O": 10.6, "H": 0.6, "F": 1.4},
        {"Rb": 15000, "Cs": 3500, "Mn": 3500, "Na": 2500, "Fe": 700, "Ca": 200},
        share=0.08, size=0.85, stretch=2.0,
    ),
)  # fmt: skip

BY_NAME = {mineral.name: mineral for mineral in MINERALS}
ELEMENTS = tuple(sorted({e for m in MINERALS for e in (*m.atoms, *m.traces_ppm)}))


@cache
def atom_fractions(name: str) -> dict[str, float]:
    """Element -> share of all atoms of a mineral, traces included; they add up to 1."""
    mineral = BY_NAME[name]
    formula_mass = sum(MASS[element] * count for element, count in mineral.atoms.items())
    moles = {e: count / formula_mass for e, count in mineral.atoms.items()}  # of 1 g of it
    for element, ppm in mineral.traces_ppm.items():
        moles[element] = moles.get(element, 0.0) + ppm * 1e-6 / MASS[element]
    total = sum(moles.values())
    return {element: amount / total for element, amount in moles.items()}
