"""Which element a column of concentrations is of, and what part of an oxide's mass it has."""

import re
from typing import Literal, get_args

# Standard atomic weights, abridged (CIAAW 2021), of the elements that reference materials certify.
WEIGHTS = """
H 1.008  Li 6.94  Be 9.0122  B 10.81  C 12.011  N 14.007  O 15.999  F 18.998  Na 22.99
Mg 24.305  Al 26.982  Si 28.085  P 30.974  S 32.06  Cl 35.45  K 39.098  Ca 40.078  Sc 44.956
Ti 47.867  V 50.942  Cr 51.996  Mn 54.938  Fe 55.845  Co 58.933  Ni 58.693  Cu 63.546  Zn 65.38
Ga 69.723  Ge 72.63  As 74.922  Se 78.971  Br 79.904  Rb 85.468  Sr 87.62  Y 88.906  Zr 91.224
Nb 92.906  Mo 95.95  Ru 101.07  Rh 102.91  Pd 106.42  Ag 107.87  Cd 112.41  In 114.82  Sn 118.71
Sb 121.76  Te 127.6  I 126.9  Cs 132.91  Ba 137.33  La 138.91  Ce 140.12  Pr 140.91  Nd 144.24
Sm 150.36  Eu 151.96  Gd 157.25  Tb 158.93  Dy 162.5  Ho 164.93  Er 167.26  Tm 168.93  Yb 173.05
Lu 174.97  Hf 178.49  Ta 180.95  W 183.84  Re 186.21  Os 190.23  Ir 192.22  Pt 195.08  Au 196.97
Hg 200.59  Tl 204.38  Pb 207.2  Bi 208.98  Th 232.04  U 238.03
"""
WEIGHT: dict[str, float] = dict(
    zip(WEIGHTS.split()[::2], map(float, WEIGHTS.split()[1::2]), strict=True)
)
# Atoms of oxygen for each atom of the element, as analyses of rocks count it; iron as FeO.
OXIDES = """
0.5 Li Na K Rb Cs Ag Tl
1.0 Be Mg Ca Sr Ba Mn Fe Co Ni Cu Zn Cd Pb
1.5 B Al Cr Sc Ga Y In As Sb Bi La Pr Nd Sm Eu Gd Tb Dy Ho Er Tm Yb Lu
2.0 Si Ti Zr Hf Sn Ge Ce Th U
2.5 P V Nb Ta
3.0 S Mo W
"""
OXYGEN = {
    name: float(n) for n, *names in map(str.split, OXIDES.strip().splitlines()) for name in names
}
Closed = Literal["oxides", "elements"]
CLOSED: tuple[Closed, ...] = get_args(Closed)
FORMULA = re.compile(r"(?:[A-Z][a-z]?\d*)+")
PART = re.compile(r"([A-Z][a-z]?)(\d*)")


def element_in(formula: str) -> tuple[str, float]:
    """The element that `Li`, `Li2O` or `SiO2` is about, and its part of the mass.

    Raises ValueError for what is neither an element nor an oxide of one.
    """
    parts = PART.findall(formula) if FORMULA.fullmatch(formula) else []
    atoms = {symbol: int(n or 1) for symbol, n in parts}
    if not parts or len(parts) != len(atoms) or 0 in atoms.values():
        raise ValueError(f"{formula!r} is not an element or an oxide such as Li2O")
    odd = [symbol for symbol in atoms if symbol not in WEIGHT]
    if odd:
        raise ValueError(f"{odd[0]!r} is not an element with a weight in labrun's table")
    others = [symbol for symbol in atoms if symbol != "O"] or ["O"]
    if len(others) > 1 or (len(atoms) == 1 and atoms[others[0]] > 1):
        raise ValueError(f"{formula!r} is neither an element nor an oxide of one")
    mass = sum(n * WEIGHT[symbol] for symbol, n in atoms.items())
    return others[0], atoms[others[0]] * WEIGHT[others[0]] / mass


def with_oxygen(element: str, closed: Closed) -> float:
    """Mass of an element with the oxygen that it binds, over its own; 1 where none is counted."""
    if closed == "elements" or element not in OXYGEN:
        return 1.0
    return 1.0 + OXYGEN[element] * WEIGHT["O"] / WEIGHT[element]
