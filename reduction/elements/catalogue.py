"""The lines worth searching for in a range of wavelengths: the strongest of each element.

Lines of one element and stage that the instrument cannot resolve are one entry, at their mean.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..lines.lines import of_lines
from ..plasma.strengths import atoms, held_by_states, log_strengths
from ..spectrum.kernel import kernel
from ..spectrum.spectrum import FloatArray, IntArray
from .abundance_prior import LOG_ODDS, log_odds

CONDITIONS = ((7_500.0, 1e17), (10_500.0, 1e17), (14_000.0, 3e16))
# Entries of an element, by how common it is: the many lines of iron explain peaks that a rare earth
# would otherwise claim; of a rare element a few dozen are evidence enough.
MOST, MOST_OFTEN, MOST_RARE = 90, 60, 36
MARGIN_NM = 0.4


@dataclass(frozen=True, slots=True, eq=False)
class Catalogue:
    """rows: of the line table, element after element, shape (n,). entry: which entry a row belongs
    to, shape (n,); begin: where the rows of each entry begin, (entries + 1,);
    first: where the entries of each element begin, shape (e + 1,). leader: the row
    (of the line table) that is strongest in each entry, shape (entries,). Of the leaders, shape
    (entries,): element, low_ev (lower level), uncertainty (of ln A), width_nm (full Stark width at
    1e17 electrons per cm3). order: the entries by wavelength. spans: those of each element.
    """

    rows: IntArray
    entry: IntArray
    begin: IntArray
    first: IntArray
    leader: IntArray
    element: IntArray
    low_ev: FloatArray
    uncertainty: FloatArray
    width_nm: FloatArray
    order: IntArray
    spans: tuple[IntArray, ...]

    def entries_of(self, elements: Sequence[int]) -> IntArray:
        """The entries of some elements, one element after the other."""
        return np.concatenate([self.spans[e] for e in elements] or [np.empty(0, np.int64)])

    def rows_of(self, entries: IntArray) -> tuple[IntArray, IntArray]:
        """The rows of some entries, and which of these each belongs to."""
        return _rows_of(self.rows, self.begin, entries)

    def strengths(self, temperature_k: float, density_per_cm3: float) -> "Expected":
        """Expected line of each entry at a temperature and density."""
        a = atoms()
        held, inverse = held_by_states(temperature_k, density_per_cm3)
        return Expected(
            *_summed(
                self.rows, self.entry, len(self.leader), held, float(inverse[0]), a.log_ga, a.species,
                a.e_k_ev, a.wavelength_nm,
            )
        )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Expected:
    """log_area: ln of the thin area for one atom of the element; vacuum_nm: where; (entries,)."""

    log_area: FloatArray
    vacuum_nm: FloatArray


@of_lines(16)
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
    leaders = np.array(leader, dtype=np.int64)
    begin = np.searchsorted(which, np.arange(len(leader) + 1))
    return Catalogue(
        flat, which, begin, np.array(first), leaders, a.element[leaders], a.e_i_ev[leaders],
        a.uncertainty[leaders], a.width_nm[leaders], np.argsort(a.wavelength_nm[leaders]),
        tuple(np.arange(begin, end) for begin, end in pairwise(first)),
    )  # fmt: skip


@kernel
def _rows_of(rows, begin, entries):
    n = 0
    for e in entries:
        n += begin[e + 1] - begin[e]
    own, which = np.empty(n, np.int64), np.empty(n, np.int64)
    n = 0
    for k in range(len(entries)):
        for i in range(begin[entries[k]], begin[entries[k] + 1]):
            own[n], which[n] = rows[i], k
            n += 1
    return own, which


@kernel
def _summed(rows, entry, n, held, inverse, log_ga, species, e_k_ev, wavelength_nm):
    """ln of the sum of each entry's strengths, and their mean wavelength; rows in order of entry."""
    log_sum, mean_nm, log = np.empty(n), np.empty(n), np.empty(len(rows))
    for i in range(len(rows)):
        row = rows[i]
        log[i] = log_ga[row] + held[species[row]] + inverse * e_k_ev[row]
    i = 0
    for k in range(n):
        begin, top = i, log[i]
        while i < len(entry) and entry[i] == k:
            top = max(top, log[i])
            i += 1
        if i == begin + 1:  # as most are
            log_sum[k], mean_nm[k] = top, wavelength_nm[rows[begin]]
            continue
        total, moment = 0.0, 0.0
        for j in range(begin, i):
            weight = np.exp(log[j] - top)
            total += weight
            moment += weight * wavelength_nm[rows[j]]
        log_sum[k], mean_nm[k] = np.log(total) + top, moment / total
    return log_sum, mean_nm


def _most(odds: float) -> int:
    return MOST if odds == 0.0 else MOST_OFTEN if odds > LOG_ODDS["rarely"] else MOST_RARE


def _together(rows: IntArray, strength: FloatArray, apart_nm: float, most: int) -> list[IntArray]:
    """Groups of rows, strongest group first, its strongest row first."""
    nm, ion = atoms().wavelength_nm[rows], atoms().ion[rows]
    order = np.argsort(-strength)
    order = order[: 6 * most]
    free = np.zeros(len(rows), dtype=bool)
    free[order] = True
    close = np.diff(nm) < apart_nm
    alone = ~(np.append(close, False) | np.append(False, close))  # as most are
    groups = []
    for k in order:
        if not free[k]:
            continue
        if alone[k]:
            groups.append(rows[k : k + 1])
            if len(groups) == most:
                break
            continue
        near = np.flatnonzero(free & (np.abs(nm - nm[k]) < apart_nm) & (ion == ion[k]))
        near = near[np.argsort(-strength[near])]
        free[near] = False
        groups.append(rows[near])
        if len(groups) == most:
            break
    return groups
