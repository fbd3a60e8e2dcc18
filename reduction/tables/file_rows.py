"""The row of `files`: the outcome of one file, with the reason for a failure."""

import numpy as np

from ..reduce import Reduction
from ..spectrum.spectrum import Spectrum
from .columns import BETWEEN_FLAGS, Cells

REDUCED, FAILED = "reduced", "failed"


def file_row(spectrum: Spectrum, reduction: Reduction) -> Cells:
    """A spectrum that was reduced."""
    offset_nm = reduction.offsets.offset_nm
    return {
        "status": [REDUCED],
        "reason": [""],
        "channels": [len(spectrum)],
        "first_nm": [float(spectrum.wavelength_nm[0])],
        "last_nm": [float(spectrum.wavelength_nm[-1])],
        "bad_channels": [int(np.count_nonzero(reduction.bad.any))],
        "saturated_channels": [int(np.count_nonzero(reduction.bad.full))],
        "medium": [reduction.medium],
        "offset_low_nm": [float(offset_nm.min())],
        "offset_high_nm": [float(offset_nm.max())],
        "n_peaks": [reduction.n_peaks],
        "notes": [BETWEEN_FLAGS.join(reduction.notes)],
    }


def failed_row(reason: str) -> Cells:
    """A file that is not a spectrum, or could not be reduced."""
    nothing = [None]
    return {
        "status": [FAILED], "reason": [reason], "channels": nothing, "first_nm": nothing,
        "last_nm": nothing, "bad_channels": nothing, "saturated_channels": nothing,
        "medium": [""], "offset_low_nm": nothing, "offset_high_nm": nothing, "n_peaks": nothing,
        "notes": [""],
    }  # fmt: skip
