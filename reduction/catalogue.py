"""The lines worth looking for within a range of wavelengths: of each element the strongest.

Lines of one element and stage that the instrument cannot part are one entry, at their mean.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .commonness import LOG_ODDS, log_odds
from .spectrum import FloatArray, IntArray
from .strengths import atoms, log_strengths

CONDITIONS = ((7_500.0, 1e17), (10_500.0, 1e17), (14_000.0, 3e16))
# Entries of an element, by how common it is: the many lines of iron explain peaks that a rare earth
# would otherwise claim; of a rare element a few dozen are evidence enough.
MOST, MOST_OFTEN, MOST_RARE = 90, 60, 36
MARGIN_NM = 0.4


@dataclass(frozen=True, slots=True, eq=False)
class Catalogue:
    """rows: of the line table, element after element, shape (n,). entry: which entry a row belongs
    to, shape (n,); first: where the entries of each element begin, shape (e + 1,). leader: the row
    (of the line table) that is strongest in each entry, shape (entries,).
    """

    rows: IntArray
    entry: IntArray
    first: IntArray
    leader: IntArray

    def strengths(self, temperature_k: float, density_per_cm3: float) -> "Expected":
        """What each entry should show at a temperature and density."""
        log = log_strengths(self.rows, temperature_k, density_per_cm3)
        top = float(np.max(log, initial=0.0))
        weight = np.exp(log - top)
        n = len(self.leader)
        total = np.bincount(self.entry, weight, n)
        mean = np.bincount(self.entry, weight * atoms().wavelength_nm[self.rows], n)
        safe = np.maximum(total, 1e-300)
        return Expected(np.log(safe) + top, mean / safe)


@dataclass(frozen=True, slots=True, eq=False)
class Expected:
    """log_area: ln of the thin area for one atom of the element; vacuum_nm: where; (entries,)."""

    log_area: FloatArray
    vacuum_nm: FloatArray


@lru_cache(maxsize=16)
def catalogue(first_nm: float, last_nm: float, apart_nm: float) -> Catalogue:
    """The entries between two wavelengths; lines nearer than `apart_nm` are one entry."""
    a = atoms()
    inside = np.flatnonzero(
        (a.wavelength_nm > first_nm - MARGIN_NM) & (a.wavelength_nm < last_nm + MARGIN_NM)
    )
    strongest = np.max([log_strengths(inside, t, n) for t, n in CONDITIONS], axis=0)
    rows, entry, leader, first = [], [], [], [0]
    odds = log_odds()
    for e in range(len(a.elements)):
        own = np.flatnonzero(a.element[inside] == e)
        for group in _together(inside[own], strongest[own], apart_nm, _most(odds[e])):
            rows.append(group)
            entry.append(np.full(len(group), len(leader)))
            leader.append(group[0])
        first.append(len(leader))
    flat = np.concatenate(rows) if rows else np.empty(0, np.int64)
    which = np.concatenate(entry) if entry else np.empty(0, np.int64)
    return Catalogue(flat, which, np.array(first), np.array(leader, dtype=np.int64))


def _most(odds: float) -> int:
    return MOST if odds == 0.0 else MOST_OFTEN if odds > LOG_ODDS["rarely"] else MOST_RARE


def _together(rows: IntArray, strength: FloatArray, apart_nm: float, most: int) -> list[IntArray]:
    """Groups of rows, strongest group first, its strongest row first."""
    nm, ion = atoms().wavelength_nm[rows], atoms().ion[rows]
    order = np.argsort(-strength)
    order = order[: 6 * most]
    free = np.zeros(len(rows), dtype=bool)
    free[order] = True
    groups = []
    for k in order:
        if not free[k]:
            continue
        near = np.flatnonzero(free & (np.abs(nm - nm[k]) < apart_nm) & (ion == ion[k]))
        near = near[np.argsort(-strength[near])]
        free[near] = False
        groups.append(rows[near])
        if len(groups) == most:
            break
    return groups
