"""The process in which SciPy reads a MATLAB file without compression: altered bytes may end it.

It imports nothing of labrun, and labrun imports it nowhere: it is started as a script. From standard input
the file; to standard output a line of JSON, the names of its arrays or what went wrong, and the arrays.
"""

import json
import sys
from collections.abc import Mapping
from io import BytesIO

import numpy as np
from scipy.io import loadmat


def main() -> None:
    told = sys.stdout.buffer
    try:
        arrays = dict(_arrays(loadmat(BytesIO(sys.stdin.buffer.read()), simplify_cells=True)))
        said = {"names": list(arrays)}
    except Exception as fault:  # what it raises has no common base
        arrays, said = {}, {"fault": f"{type(fault).__name__}: {fault}"}
    told.write(json.dumps(said).encode() + b"\n")
    for one in arrays.values():
        np.save(told, one, allow_pickle=False)
    told.flush()


def _arrays(said, within=""):
    """The arrays of numbers, those of structures too."""
    for name, one in said.items():
        if isinstance(one, Mapping):
            yield from _arrays(one, f"{within}{name}/")
        elif isinstance(one, np.ndarray) and one.dtype.kind in "fiu" and one.size > 1:
            yield within + name, one


if __name__ == "__main__":
    main()
