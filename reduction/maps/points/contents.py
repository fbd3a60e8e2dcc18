"""Concentrations at points: values with errors, and what is known where there is no value."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...lines.symbols import SYMBOLS
from ...spectrum.spectrum import BoolArray, FloatArray, IntArray, TextArray
from .columns import Columns

VALUE, ERROR, LOW, HIGH, FLAGS = (
    "wt_percent", "wt_percent_err", "wt_percent_low", "wt_percent_high", "wt_percent_flags",
)  # fmt: skip
BELOW, ABOVE = "below LOD", "above range"


@dataclass(frozen=True, slots=True, eq=False)
class Contents:
    """Of one element, wt %, shape (n,): value with its standard error, ends of the 95 % interval,
    NaN where unknown; flags as in the table `elements`."""

    value: FloatArray
    error: FloatArray
    low: FloatArray
    high: FloatArray
    flags: TextArray

    @property
    def below(self) -> BoolArray:
        """Points below the limit of detection; `high` is the upper limit there."""
        return self._flagged(BELOW)

    @property
    def above(self) -> BoolArray:
        """Points above the standards, whether the curve still tells a value or not."""
        return self._flagged(ABOVE)

    @property
    def covered(self) -> BoolArray:
        """Points within what the calibration covers."""
        return np.isfinite(self.value) & ~self.below & ~self.above

    @property
    def known(self) -> BoolArray:
        """Points of which the calibration says anything."""
        return np.isfinite(self.value) | self.below | self.above

    def counts(self) -> dict[str, int]:
        """How many points are of which kind."""
        masks = {"covered": self.covered, "below_lod": self.below, "above_range": self.above}
        return {word: int(np.sum(mask)) for word, mask in masks.items()}

    def _flagged(self, word: str) -> BoolArray:
        return np.array([word in one for one in self.flags], dtype=bool)


def of_columns(columns: Columns, before: str = "") -> Contents:
    """The contents in a table's columns, whose names begin with `before`.

    Where there are no flags, an upper end alone is a point below the limit of detection.
    """
    value, error, low, high = (columns.numbers(before + n) for n in (VALUE, ERROR, LOW, HIGH))
    flags = np.array(columns.text(before + FLAGS), dtype=object)
    if before + FLAGS not in columns:
        flags[np.isnan(value) & np.isnan(low) & np.isfinite(high)] = BELOW
        flags[np.isnan(value) & np.isfinite(low) & np.isnan(high)] = ABOVE
    return Contents(value, error, low, high, flags)


def of_rows(columns: Columns) -> dict[str, Contents]:
    """By element, from columns such as `Li_wt_percent`, `Li_wt_percent_err` of a run's rows."""
    ending = f"_{VALUE}"
    named = [name.removesuffix(ending) for name in columns.cells if name.endswith(ending)]
    return {name: of_columns(columns, f"{name}_") for name in named if name in SYMBOLS}


def of_spectra(table: Columns, at: IntArray, n: int) -> dict[str, Contents]:
    """By element, shape (n,) spectra, from the table `elements`; `at`: the spectrum of each row."""
    if VALUE not in table:
        return {}
    rows, element = of_columns(table), np.array(table.text("element"), dtype=str)
    found = {}
    for name in dict.fromkeys(element[rows.known].tolist()):
        own = np.flatnonzero(element == name)
        place = np.full(n, -1)
        place[at[own]] = own
        found[name] = taken(rows, place)
    return found


def taken(contents: Contents, at: IntArray) -> Contents:
    """The contents at these places, shape of `at`; unknown where one is -1."""
    there = at >= 0
    numbers = (contents.value, contents.error, contents.low, contents.high)
    value, error, low, high = (np.where(there, one[at], np.nan) for one in numbers)
    return Contents(value, error, low, high, np.where(there, contents.flags[at], ""))


def _unknown(n: int) -> Contents:
    value, error, low, high = (np.full(n, np.nan) for _ in range(4))
    return Contents(value, error, low, high, np.full(n, "", dtype=object))


def joined(parts: Sequence[tuple[Contents | None, int]]) -> Contents:
    """One after the other, each with its length; None is unknown."""
    whole = [_unknown(n) if one is None else one for one, n in parts]
    value, error, low, high, flags = (
        np.concatenate([getattr(one, name) for one in whole])
        for name in ("value", "error", "low", "high", "flags")
    )
    return Contents(value, error, low, high, flags)


def averaged(contents: Contents, which: IntArray) -> Contents:
    """The mean of each group, `which` being the group of each point.

    Its error is the mean of theirs, as what a calibration errs it errs in all of them. Where one of
    a group has no value the mean has none, and the ends are those that hold all.
    """
    n = int(which.max()) + 1
    found = _unknown(n)
    for group in range(n):
        own = np.flatnonzero((which == group) & contents.known)
        if not len(own):
            continue
        found.value[group] = contents.value[own].mean()
        found.error[group] = contents.error[own].mean()
        told = bool(np.isfinite(found.value[group]))
        low, high = contents.low[own], contents.high[own]
        found.low[group] = low.mean() if told else low.min()
        found.high[group] = high.mean() if told else high.max()
        said = [flag for one in contents.flags[own] for flag in str(one).split("; ") if flag]
        found.flags[group] = "; ".join(dict.fromkeys(said))
    return found
