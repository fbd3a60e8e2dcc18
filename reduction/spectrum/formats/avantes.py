"""Avantes AvaSoft 8 (.raw8 and its kin, .str8), read by avaread."""

import numpy as np

from ..fault import Unreadable
from ..readout import Readout
from .library import library, on_disk, spoiled

NAME = "an AvaSoft 8 file"
LIBRARY = "avaread"
SINGLE, SERIES = b"AVS8", b"STR8"


def begins(raw: bytes) -> bool:
    return raw.startswith((SINGLE, SERIES))


def read(raw: bytes) -> Readout:
    """The channels of one file are the ranges of one spectrum; the frames of a series are shots."""
    avaread = library(LIBRARY, NAME)
    series = raw.startswith(SERIES)
    with on_disk(raw, ".str8" if series else ".raw8") as path:
        try:
            file = avaread.read_file(path)
            if series:
                axis = np.asarray(file.wavelength, dtype=np.float64)
                shots = np.stack([np.asarray(frame, dtype=np.float64) for frame in file])
            else:
                ranges = list(file)
                axis = np.concatenate([one.wavelength for one in ranges]).astype(np.float64)
                shots = np.concatenate([one.signal for one in ranges]).astype(np.float64)[None]
        except Exception as fault:  # what it raises has no common base
            raise spoiled(NAME, fault) from fault
    if not shots.size or shots.shape[-1] != len(axis):
        raise Unreadable(f"{NAME} with {len(axis)} wavelengths and counts of shape {shots.shape}")
    notes = ("the dark spectrum that the file holds was subtracted",)
    return Readout(axis, shots, "nm", notes)
