"""MATLAB up to version 7 (.mat), read by scipy, and NumPy's .npz: named arrays. (7.3 is HDF5.)"""

from collections.abc import Mapping
from io import BytesIO
from typing import Any

import numpy as np

from ..readout import Readout
from .library import library, spoiled
from .named import chosen, only_table, readout
from .zipped import first_name

NAME = "a MATLAB or .npz file"
LIBRARY = "scipy"
MAGIC = b"MATLAB 5.0 MAT-file"


def begins(raw: bytes) -> bool:
    return raw.startswith(MAGIC) or first_name(raw).endswith(".npy")


def read(raw: bytes, columns: tuple[str, ...] | None = None) -> Readout:
    try:
        if raw.startswith(MAGIC):
            library(LIBRARY, NAME)
            from scipy.io import loadmat

            said: Mapping[str, Any] = loadmat(BytesIO(raw), simplify_cells=True)
        else:
            with np.load(BytesIO(raw), allow_pickle=False) as file:
                said = {name: file[name] for name in file.files}
    except Exception as fault:  # what these raise has no common base
        raise spoiled(NAME, fault) from fault
    arrays = dict(_arrays(said))
    if columns is None and (told := only_table(arrays)) is not None:
        return told
    axis, counts = chosen(arrays, columns, NAME)
    return readout((axis, arrays[axis]), (counts, arrays[counts]))


def _arrays(said: Mapping[str, Any], within: str = "") -> list[tuple[str, np.ndarray]]:
    """The arrays of numbers, those of structures too, without sides of one."""
    found: list[tuple[str, np.ndarray]] = []
    for name, one in said.items():
        if isinstance(one, Mapping):
            found += _arrays(one, f"{within}{name}/")
        elif isinstance(one, np.ndarray) and one.dtype.kind in "fiu" and one.size > 1:
            found.append((within + name, np.squeeze(one)))
    return found
