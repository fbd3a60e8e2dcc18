"""What is shot at: shares of atoms, or of mass where that is how people know it."""

import numpy as np

WEIGHT = {
    "H": 1.0, "Li": 6.9, "Be": 9.0, "B": 10.8, "C": 12.0, "N": 14.0, "O": 16.0, "F": 19.0,
    "Na": 23.0, "Mg": 24.3, "Al": 27.0, "Si": 28.1, "P": 31.0, "S": 32.1, "Cl": 35.5, "Ar": 39.9,
    "K": 39.1, "Ca": 40.1, "Ti": 47.9, "V": 50.9, "Cr": 52.0, "Mn": 54.9, "Fe": 55.8, "Co": 58.9,
    "Ni": 58.7, "Cu": 63.5, "Zn": 65.4, "Br": 79.9, "Rb": 85.5, "Sr": 87.6, "Mo": 95.9,
    "Ag": 107.9, "Cd": 112.4, "Sn": 118.7, "Sb": 121.8, "Cs": 132.9, "Ba": 137.3, "La": 138.9,
    "Ce": 140.1, "W": 183.8, "Pb": 207.2, "He": 4.0,
}  # fmt: skip

ATOMS = {  # atoms a formula unit
    "spodumene": {"Li": 1, "Al": 1, "Si": 2, "O": 6, "Fe": 0.03, "Mn": 0.006, "Na": 0.02},
    "quartz": {"Si": 1, "O": 2, "Al": 3e-4, "Na": 1e-4, "Ti": 3e-5, "Li": 5e-5, "H": 2e-3},
    "albite": {"Na": 1, "Al": 1, "Si": 3, "O": 8, "Ca": 0.03, "K": 0.02, "H": 0.02, "Fe": 2e-3},
    "muscovite": {
        "K": 1, "Al": 3, "Si": 3, "O": 12, "H": 2, "Rb": 0.012, "Fe": 0.06, "Na": 0.07,
        "Li": 0.015, "Mn": 0.005, "Mg": 0.02, "Ti": 0.003,
    },
    "K-feldspar": {
        "K": 1, "Al": 1, "Si": 3, "O": 8, "Rb": 0.011, "Na": 0.11, "Cs": 5e-4, "Ca": 2e-3,
        "Ba": 2e-3, "H": 0.02,
    },
    "lepidolite": {
        "K": 1, "Li": 1.7, "Al": 1.9, "Si": 3.4, "O": 10.6, "H": 0.6, "F": 1.4, "Rb": 0.07,
        "Cs": 0.01, "Mn": 0.025, "Na": 0.04, "Fe": 5e-3,
    },
    "limestone": {
        "Ca": 1, "C": 1, "O": 3, "Mg": 0.04, "Sr": 8e-4, "Si": 0.02, "Al": 6e-3, "Fe": 4e-3,
        "Mn": 4e-4, "Na": 5e-4, "H": 0.03,
    },
    "brine residue": {
        "Na": 1, "Cl": 1.6, "K": 0.3, "Mg": 0.25, "Li": 0.12, "Ca": 0.05, "S": 0.05, "B": 0.04,
        "H": 0.6, "O": 0.8, "Br": 2e-3, "Sr": 1e-3, "Rb": 2e-4,
    },
    # Held out: no choice in the package was made with these.
    "apatite": {
        "Ca": 5, "P": 3, "O": 12, "F": 0.8, "Cl": 0.1, "H": 0.2, "Sr": 0.01, "Mn": 0.01,
        "Na": 0.02, "Ce": 0.01, "La": 5e-3,
    },
    "barite": {"Ba": 1, "S": 1, "O": 4, "Sr": 0.04, "Ca": 0.01, "Fe": 2e-3, "H": 0.02},
    "galena": {"Pb": 1, "S": 1, "Zn": 0.1, "Fe": 0.02, "Cd": 2e-3, "Ag": 2e-3, "Sb": 3e-3,
               "Ca": 0.02, "C": 0.02, "O": 0.1},
    "beryl": {"Be": 3, "Al": 2, "Si": 6, "O": 18, "H": 0.4, "Na": 0.06, "Fe": 0.03, "Cs": 0.01,
              "Li": 0.03, "Mg": 0.02},
}  # fmt: skip
GRAMS = {
    "steel": {"Fe": 70, "Cr": 18, "Ni": 9, "Mn": 1.5, "Si": 0.6, "Mo": 0.8, "Cu": 0.3, "V": 0.1},
    "basalt glass": {
        "Si": 23, "O": 45, "Al": 7.5, "Fe": 8.5, "Mg": 4.5, "Ca": 8, "Na": 1.8, "K": 0.4,
        "Ti": 1.2, "Mn": 0.13, "P": 0.1, "Sr": 0.03, "Ba": 0.02, "V": 0.03, "Cr": 0.03,
    },
    "aluminium alloy": {
        "Al": 92, "Si": 1, "Mg": 2, "Cu": 4, "Mn": 0.6, "Fe": 0.3, "Zn": 0.2, "Ti": 0.05,
    },
    "bronze": {"Cu": 85, "Sn": 9, "Pb": 4, "Zn": 1.5, "Ni": 0.3, "Fe": 0.1},
    "titanium alloy": {"Ti": 90, "Al": 6, "V": 4, "Fe": 0.15},
    "granite": {
        "O": 48, "Si": 33, "Al": 7.5, "K": 4, "Na": 2.6, "Ca": 1.2, "Fe": 2, "Mg": 0.4, "Ti": 0.2,
        "Mn": 0.05, "Ba": 0.06, "Rb": 0.02, "Sr": 0.02, "Li": 0.005,
    },
}  # fmt: skip
TRAIN = (
    "spodumene", "quartz", "albite", "muscovite", "K-feldspar", "lepidolite", "limestone",
    "brine residue", "steel", "basalt glass", "aluminium alloy",
)  # fmt: skip
HELD_OUT = (
    "apatite", "barite", "galena", "beryl", "bronze", "titanium alloy", "granite", "lepidolite",
    "albite", "spodumene",
)  # fmt: skip
# Looked at once, after the last choice was made with the held-out ones in view.
FRESH = (
    "granite", "muscovite", "bronze", "limestone", "beryl", "steel", "K-feldspar", "barite",
    "basalt glass", "lepidolite", "titanium alloy", "brine residue",
)  # fmt: skip


def atom_shares(sample: str, rng: np.random.Generator, gas: str) -> dict[str, float]:
    """Shares of atoms, each varied by a tenth (traces by half), with the gas around the plasma."""
    if sample in ATOMS:
        atoms = dict(ATOMS[sample])
    else:
        atoms = {element: grams / WEIGHT[element] for element, grams in GRAMS[sample].items()}
    total = sum(atoms.values())
    shares = {}
    for element, amount in atoms.items():
        spread = 0.1 if amount / total > 0.02 else 0.5
        shares[element] = amount / total * float(np.exp(spread * rng.standard_normal()))
    around = {"argon": {"Ar": 0.08, "H": 0.005}, "air": {"N": 0.08, "O": 0.03, "H": 0.01},
              "helium": {"He": 0.06, "H": 0.003}, "none": {"H": 0.002}}[gas]  # fmt: skip
    for element, amount in around.items():
        shares[element] = shares.get(element, 0.0) + amount * rng.uniform(0.5, 1.5)
    total = sum(shares.values())
    return {element: amount / total for element, amount in shares.items()}
