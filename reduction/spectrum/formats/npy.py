"""NumPy's .npy: wavelengths first, then a row (or a column) for each shot."""

from io import BytesIO

import numpy as np

from ..fault import Unreadable
from ..readout import Readout
from .named import of_table

NAME = "a NumPy file"
MAGIC = b"\x93NUMPY"


def begins(raw: bytes) -> bool:
    return raw.startswith(MAGIC)


def read(raw: bytes) -> Readout:
    """Shape (1 + shots, n) or (n, 1 + shots)."""
    try:
        table = np.load(BytesIO(raw), allow_pickle=False)
    except ValueError as fault:
        raise Unreadable(f"this .npy file cannot be read: {fault}") from fault
    if table.ndim != 2 or min(table.shape) < 2 or table.dtype.kind not in "fiu":
        raise Unreadable(
            f"a table of shape {table.shape} is not a spectrum; it needs wavelengths and shots"
        )
    return of_table(table)
