"""Prior probability of each element, as the natural logarithm of the odds.

For rocks, soils, metals, glass and the gases around a plasma: an element present at a per cent or
more needs the least evidence, a trace needs more, one without a stable isotope needs a great deal.
A laboratory that measures rare earths all day should use its own.
"""

import numpy as np

from ..lines.lines import of_lines
from ..plasma.strengths import atoms

EVERYWHERE = frozenset((
    "H", "Li", "C", "N", "O", "Na", "Mg", "Al", "Si", "K", "Ca", "Ti", "Cr", "Mn", "Fe", "Ni",
    "Cu", "Zn", "Ar", "Ba", "Sr", "Rb",
))  # fmt: skip
OFTEN = frozenset((
    "Be", "B", "F", "P", "S", "Cl", "V", "Co", "Cs", "Pb", "Sn", "He", "Mo", "Ag", "Cd", "Sb",
    "W", "As", "Y", "La", "Ce", "Nd", "Ga", "Ge", "Br",
))  # fmt: skip
NEVER = frozenset(("Tc", "Fr", "Ra", "Ac"))
# What an element hardly comes without in rocks, soils, ores and the metals that are made of them.
RARE_EARTHS = frozenset(("Y", "La", "Ce", "Nd"))
NOBLE = frozenset(("Ru", "Rh", "Pd", "Os", "Ir", "Pt", "Au", "Ag", "Cu"))
COMPANY = {
    **dict.fromkeys(
        ("La", "Ce", "Pr", "Nd", "Sm", "Eu", "Gd", "Tb", "Dy", "Ho", "Er", "Tm", "Yb", "Lu"),
        RARE_EARTHS,
    ),
    **dict.fromkeys(("Ru", "Rh", "Pd", "Os", "Ir", "Pt"), NOBLE),
    "Th": RARE_EARTHS | {"U"}, "U": RARE_EARTHS | {"Th"},
    "Hf": frozenset(("Zr",)), "Ta": frozenset(("Nb",)), "Nb": frozenset(("Ta", "Ti", "Zr")),
    "Re": frozenset(("Mo",)),
}  # fmt: skip
LOG_ODDS = {"everywhere": 0.0, "often": -2.0, "rarely": -5.0, "never": -15.0}


@of_lines()
def log_odds() -> np.ndarray:
    """The prior of each element in the order of `strengths.atoms().elements`, shape (e,)."""

    def of(symbol: str) -> float:
        if symbol in EVERYWHERE:
            return LOG_ODDS["everywhere"]
        if symbol in NEVER:
            return LOG_ODDS["never"]
        return LOG_ODDS["often" if symbol in OFTEN else "rarely"]

    return np.array([of(symbol) for symbol in atoms().elements.tolist()])
