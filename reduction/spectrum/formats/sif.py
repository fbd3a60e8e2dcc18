"""Andor Solis .sif, read by sif_parser: one spectrum, a series of them, or several tracks."""

from io import FileIO

import numpy as np

from ..fault import Unreadable
from ..readout import Readout
from .library import library, on_disk, spoiled

NAME = "an Andor .sif file"
LIBRARY = "sif_parser"
MAGIC = b"Andor Technology Multi-Channel File"
MOST_TRACKS = 32  # more rows are a picture


def begins(raw: bytes) -> bool:
    return raw.startswith(MAGIC)


def read(raw: bytes) -> Readout:
    parser = library(LIBRARY, NAME)
    try:
        with on_disk(raw, ".sif") as path, _Ending(path) as file:
            frames, info = parser.np_open(file)
        axis = parser.utils.extract_calibration(info)
    except Exception as fault:  # what it raises has no common base
        raise spoiled(NAME, fault) from fault
    if axis is None:
        raise Unreadable(
            f"{NAME} without a calibrated axis: calibrate the spectrograph in Solis, or export "
            "wavelengths and counts as text"
        )
    n = frames.shape[-1]
    if frames.shape[-2] > MOST_TRACKS:
        raise Unreadable(
            f"{NAME} with a picture of {frames.shape[-2]} rows, not spectra: bin it vertically"
        )
    axis = np.asarray(axis, dtype=np.float64)
    axes = axis.reshape(-1, n)
    if not (axes == axes[0]).all():
        raise Unreadable(f"{NAME} whose frames have different axes: export them one by one")
    return Readout(axes[0], np.asarray(frames, dtype=np.float64).reshape(-1, n))


class _Ending(FileIO):
    """A file with an end: sif_parser would look for the next word of a cut file for ever."""

    def read(self, size: int | None = -1, /) -> bytes:
        found = super().read(-1 if size is None else size)
        if not found and size:
            raise EOFError("the file ends before its end")
        return found
