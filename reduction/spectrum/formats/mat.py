"""MATLAB up to version 7 (.mat), read by scipy, and NumPy's .npz: named arrays. (7.3 is HDF5.)"""

import json
import subprocess
import sys
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from ..readout import Readout
from .library import library, spoiled
from .named import chosen, only_table, readout
from .zipped import first_name

NAME = "a MATLAB or .npz file"
LIBRARY = "scipy"
MAGIC = b"MATLAB 5.0 MAT-file"
COMPRESSED = (b"\x0f\0\0\0", b"\0\0\0\x0f")
"""How what follows the header begins where it is compressed, as MATLAB writes it: that has a checksum."""
HEADER = 128
LIMIT_S = 120.0
"""In which the process that reads one has to end."""


def begins(raw: bytes) -> bool:
    return raw.startswith(MAGIC) or first_name(raw).endswith(".npy")


def read(raw: bytes, columns: tuple[str, ...] | None = None) -> Readout:
    try:
        if raw.startswith(MAGIC):
            library(LIBRARY, NAME)
            said: Mapping[str, Any] = _matlab(raw)
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


def _matlab(raw: bytes) -> Mapping[str, Any]:
    """What it has; read in a process of its own where altered bytes may end the one that reads them."""
    if raw[HEADER : HEADER + 4] in COMPRESSED:
        from scipy.io import loadmat

        return loadmat(BytesIO(raw), simplify_cells=True)
    script = str(Path(__file__).with_name("mat_process.py"))
    ended = subprocess.run(
        [sys.executable, "-P", script], input=raw, capture_output=True, timeout=LIMIT_S, check=False
    )
    line, _, rest = ended.stdout.partition(b"\n")
    if ended.returncode or not line:
        raise ValueError(f"the process that read it ended with status {ended.returncode}")
    told = json.loads(line)
    if "fault" in told:
        raise ValueError(told["fault"])
    file = BytesIO(rest)
    return {name: np.load(file, allow_pickle=False) for name in told["names"]}


def _arrays(said: Mapping[str, Any], within: str = "") -> list[tuple[str, np.ndarray]]:
    """The arrays of numbers, those of structures too, without sides of one."""
    found: list[tuple[str, np.ndarray]] = []
    for name, one in said.items():
        if isinstance(one, Mapping):
            found += _arrays(one, f"{within}{name}/")
        elif isinstance(one, np.ndarray) and one.dtype.kind in "fiu" and one.size > 1:
            found.append((within + name, np.squeeze(one)))
    return found
