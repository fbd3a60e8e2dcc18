"""Round numbers so that their text is short, and the same on every machine."""

import numpy as np
from numpy.typing import ArrayLike

from ..spectrum.spectrum import FloatArray
from .columns import Column


def rounded(values: ArrayLike, column: Column) -> FloatArray:
    """The values rounded for their column, any shape; non-finite ones become NaN."""
    x = np.array(values, dtype=np.float64)
    x[~np.isfinite(x)] = np.nan
    if column.decimals is not None:
        np.round(x, column.decimals, out=x)
        return np.add(x, 0.0, out=x)  # no -0
    return x if column.digits is None else significant(x, column.digits)


def significant(x: FloatArray, digits: int) -> FloatArray:
    """Rounded to this many significant digits; 0 and NaN stay.

    A power of ten above 1 is exact in a double, so dividing rounds once and multiplying not at all:
    the result is the double nearest to the short decimal.
    """
    size = np.abs(x)
    known = np.isfinite(x) & (size > 0)
    power = digits - 1 - np.floor(np.log10(np.where(known, size, 1.0))).astype(np.int64)
    up, down = 10.0 ** np.clip(power, 0, 22), 10.0 ** np.clip(-power, 0, 22)
    return np.where(known, np.rint(x * up / down) / up * down, x)
