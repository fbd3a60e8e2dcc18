"""All rows of one spectrum, packed for transfer to the writer."""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from .columns import Cells

if TYPE_CHECKING:
    from ..calibration.calibration import Concentration
    from ..reduce import Reduction
    from ..spectrum.spectrum import Spectrum

Rows = dict[str, Cells]
"""The cells of one spectrum by table."""


def rows_of(
    spectrum: Spectrum,
    reduction: Reduction,
    only: Sequence[str] | None = None,
    contents: Mapping[str, Concentration] | None = None,
) -> Rows:
    """The rows by table. only: elements that get a row, all if None. contents: by element."""
    # Not for the process that only writes tables: they would compile what only a reduction needs.
    from .element_rows import element_rows
    from .file_rows import file_row
    from .peak_rows import peak_rows
    from .plasma_rows import plasma_row

    x = spectrum.wavelength_nm
    return {
        "files": file_row(spectrum, reduction),
        "peaks": peak_rows(x, reduction),
        "elements": element_rows(x, reduction, only, contents),
        "plasma": plasma_row(reduction),
    }


def packed(rows: Rows) -> bytes:
    """Pack rows for transfer from our own workers, and for our own files."""
    return pickle.dumps(rows, protocol=5)


def unpacked(raw: bytes) -> Rows:
    """The inverse of `packed`."""
    return pickle.loads(raw)
