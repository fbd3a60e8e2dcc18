"""Check standards: does a calibration still hold, by what a known sample reads now and then in a run.

The errors of concentrations are mostly those that all readings of one standard share (its matrix, the
curve), so whether the mean is right is judged by the error of one reading; whether the readings drift
is judged by their own scatter around a straight line (Student's t of its slope).
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..lines.symbols import BY_NUMBER
from ..spectrum.fault import Unreadable
from ..spectrum.spectrum import FloatArray
from .points.columns import Columns, read_columns
from .points.contents import ERROR, VALUE
from .points.rows import STANDARD

TABLES = "data*.csv"
POINT, CORRECT = "point", "correct_drift"
KNOWN, KNOWN_ERROR = "wt_percent_known", "wt_percent_known_err"
HOLDS = 2.0  # errors that the mean may be off
LEAST_OF_A_DRIFT, SURE = 4, 0.01  # readings; chance that such a slope is none
WORTH_A_WORD = 0.02  # of the mean: a smaller drift is none, however sure


@dataclass(frozen=True, slots=True, eq=False)
class Checks:
    """Readings of one standard's element in the order of the run, wt %, shape (n,): NaN where one told
    no value. known, known_error: the certificate's, the latter 0 where it says none. place: how many points
    were measured before, NaN where that is not told. correct: whether the run asks to correct by them."""

    standard: str
    element: str
    found: FloatArray
    error: FloatArray
    known: float
    known_error: float
    place: FloatArray
    correct: bool = False

    @property
    def values(self) -> FloatArray:
        """The readings that told a value."""
        return self.found[np.isfinite(self.found)]

    @property
    def error_of_one(self) -> float:
        """The usual error of a reading, 0 where none is told."""
        known = self.error[np.isfinite(self.error)]
        return float(np.median(known)) if len(known) else 0.0

    @property
    def off(self) -> float | None:
        """How far the mean is from what is known, in errors; None if nothing was told."""
        if not len(self.values):
            return None
        usual = max(np.hypot(self.error_of_one, self.known_error), 1e-12)
        return (float(self.values.mean()) - self.known) / usual

    @property
    def drift(self) -> tuple[float, float] | None:
        """Change from the first reading to the last as a part of their mean, and the chance that
        readings without a drift show as much; None of too few."""
        order = np.flatnonzero(np.isfinite(self.found)).astype(np.float64)
        n = len(order)
        if n < LEAST_OF_A_DRIFT or not self.values.mean() > 0:
            return None
        slope, start = np.polyfit(order, self.values, 1)
        left = self.values - (slope * order + start)
        error = np.sqrt(left @ left / (n - 2) / np.sum((order - order.mean()) ** 2))
        from scipy.special import stdtr  # here: a run without check standards needs no scipy

        chance = 2 * stdtr(n - 2, -abs(slope) / max(error, 1e-300))
        return float(slope * np.ptp(order) / self.values.mean()), float(chance)

    @property
    def drifts(self) -> bool:
        """Whether the readings drift."""
        return self.drift is not None and self.drift[1] < SURE and abs(self.drift[0]) > WORTH_A_WORD

    @property
    def holds(self) -> bool:
        """Whether the calibration still holds, as far as this standard tells."""
        return self.off is not None and abs(self.off) <= HOLDS and not self.drifts

    @property
    def sentence(self) -> str:
        """The verdict, and what it rests on."""
        n, off = len(self.found), self.off
        whose = f"{self.standard}: {self.element}"
        if off is None:
            return f"{whose} told no value in {n} checks, where {self.known:.4g} wt % is known"
        silent = f", {n - len(self.values)} told none" if n > len(self.values) else ""
        reads = (
            f"{whose} reads {self.values.mean():.3g} ± {self.error_of_one:.2g} wt % (mean of "
            f"{len(self.values)}{silent}; error of one), where {self.known:.4g} is known"
        )
        if abs(off) > HOLDS:
            reads += f": {abs(off):.1f} errors off, the calibration does not hold; calibrate anew"
        elif self.drifts:
            reads += ": within errors, but the instrument drifts"
        else:
            reads += ": the calibration holds"
        if self.drift is None:
            return f"{reads}; {LEAST_OF_A_DRIFT} checks or more would tell a drift"
        change, chance = self.drift
        if self.drifts:
            way = "rises" if change > 0 else "falls"
            return f"{reads}; it {way} by {100 * abs(change):.0f} % from first to last (p = {chance:.1g})"
        return f"{reads}; no drift is seen"


def read_checks(folder: Path) -> list[Checks]:
    """All checks in the rows of a run: tables with a column `standard` and what is known of it, such
    as `Li_wt_percent_known` beside `Li_wt_percent`."""
    found = []
    for path in sorted(folder.glob(TABLES)):
        try:
            table = read_columns(path)
        except Unreadable:
            continue  # said where its points are gathered
        found += _in_table(table)
    return found


def _in_table(table: Columns) -> list[Checks]:
    if STANDARD not in table:
        return []
    names = np.array(table.text(STANDARD), dtype=object)
    elements = [e for e in BY_NUMBER.split() if f"{e}_{KNOWN}" in table and f"{e}_{VALUE}" in table]
    found = []
    for standard in dict.fromkeys(filter(None, names.tolist())):
        own = names == standard
        for element in elements:
            value, error, known, known_error = (
                table.numbers(f"{element}_{column}")[own]
                for column in (VALUE, ERROR, KNOWN, KNOWN_ERROR)
            )
            certified = known[np.isfinite(known)]
            if len(certified):
                sure = float(np.nanmax(np.append(known_error, 0.0)))
                place = table.numbers(POINT)[own]
                correct = np.array(table.text(CORRECT))[own]
                asked = bool(np.any(np.char.lower(correct) == "true"))
                found.append(
                    Checks(standard, element, value, error, float(certified[0]), sure, place, asked)
                )
    return found
