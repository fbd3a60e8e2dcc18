"""Several shots on one axis: kept one by one, or averaged into one spectrum."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .axis import Unit, in_nm
from .fault import Unreadable
from .source import bytes_of
from .spectrum import FloatArray, Spectrum

SPACED = str.maketrans(",;\t", "   ")
NPY_MAGIC = b"\x93NUMPY"


@dataclass(frozen=True, slots=True, eq=False)
class Shots:
    """wavelength_nm: shape (n,), ascending. intensity: shape (shots, n), counts; NaN is bad."""

    wavelength_nm: FloatArray
    intensity: FloatArray

    def __len__(self) -> int:
        return len(self.intensity)

    def each(self) -> list[Spectrum]:
        """One spectrum per shot."""
        return [Spectrum(self.wavelength_nm, counts) for counts in self.intensity]

    def mean(self) -> Spectrum:
        """The average of the shots; a channel that is bad in some is the mean of the others."""
        good = np.isfinite(self.intensity)
        total = np.where(good, self.intensity, 0.0).sum(axis=0)
        count = good.sum(axis=0)
        mean = np.divide(total, count, out=np.full(len(total), np.nan), where=count > 0)
        return Spectrum(self.wavelength_nm, mean)


def read_shots(source: Path | str | bytes, unit: Unit = "nm") -> Shots:
    """The shots in a table: wavelength first, then a column (a row, in .npy) for each shot.

    Delimited text (comma, semicolon, tab, spaces; header and # lines are skipped) or .npy of
    shape (1 + shots, n) or (n, 1 + shots). Raises Unreadable, with a sentence, for anything else.
    """
    raw = bytes_of(source)
    table = _npy(raw) if raw.startswith(NPY_MAGIC) else _text(raw)
    if table.ndim != 2 or min(table.shape) < 2 or table.dtype.kind not in "fiu":
        raise Unreadable(
            f"a table of shape {table.shape} is not a spectrum; it needs wavelengths and shots"
        )
    table = table.astype(np.float64)
    table = table if table.shape[0] < table.shape[1] else table.T
    if not np.isfinite(table[0]).all():
        raise Unreadable("a wavelength is not a number")
    return _ascending(in_nm(table[0], unit), np.where(np.isfinite(table[1:]), table[1:], np.nan))


def _npy(raw: bytes) -> np.ndarray:
    from io import BytesIO

    try:
        return np.load(BytesIO(raw), allow_pickle=False)
    except ValueError as fault:
        raise Unreadable(f"this .npy file cannot be read: {fault}") from fault


def _text(raw: bytes) -> np.ndarray:
    try:
        lines = raw.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise Unreadable("this is neither UTF-8 text nor a .npy file") from None
    rows = []
    for number, line in enumerate(lines, start=1):
        text = line.translate(SPACED).strip()
        if not text or text.startswith("#"):
            continue
        try:
            rows.append([float(field) for field in text.split()])
        except ValueError:
            if rows:
                raise Unreadable(f"line {number} is not numeric: {line[:40]!r}") from None
    if not rows:
        raise Unreadable("the file is empty: it has no row of numbers")
    lengths = {len(row) for row in rows}
    if len(lengths) > 1:
        raise Unreadable(
            f"the rows have {min(lengths)} to {max(lengths)} columns; all need the same number"
        )
    return np.array(rows)


def _ascending(wavelength_nm: FloatArray, intensity: FloatArray) -> Shots:
    unique, first = np.unique(wavelength_nm, return_index=True)
    return Shots(unique, np.ascontiguousarray(intensity[:, first]))
