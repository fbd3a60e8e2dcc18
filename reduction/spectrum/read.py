"""Read spectra from the files of analysers and spectrometers, whatever their dialect.

What cannot be read with certainty is refused, with the line and the way on.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from .axis import Unit, in_nm
from .fault import Unreadable
from .formats import avantes, hdf5, npy, sif, spc
from .readout import Readout
from .shots import Shots
from .source import bytes_of, unpacked
from .spectrum import FloatArray, Spectrum
from .text import read_text

FORMATS = (npy, hdf5, sif, spc, avantes)
LEAST_DISTINCT = 0.6  # of the wavelengths; fewer are not the axis of one spectrum
SOME_BACK = 0.02  # of the steps; more are not the edges of detectors or orders


def read_spectrum(
    source: Path | str | bytes, unit: Unit | None = None, columns: Sequence[str] | None = None
) -> Spectrum:
    """The spectrum in a file, or in the bytes of one; several shots are averaged.

    Wavelengths in nm, ascending (rows are sorted, equal wavelengths averaged); intensities in
    counts, NaN where the text has nan, inf or nothing. `notes` say what was noticed. unit: of the
    wavelengths in the file; as its heading says, else nm, if None. columns: which to read, numbers
    from 1 or headings, wavelengths first (of HDF5: two paths). Raises Unreadable, with the line and
    the way on, for what is no spectrum or could be read in two ways; OSError if the file cannot be
    opened.
    """
    return read_shots(source, unit, columns).mean()


def read_shots(
    source: Path | str | bytes, unit: Unit | None = None, columns: Sequence[str] | None = None
) -> Shots:
    """The shots in a file, as `read_spectrum` reads them, one by one."""
    raw = unpacked(bytes_of(source))
    told = _readout(raw, None if columns is None else tuple(columns))
    axis = np.asarray(told.axis, dtype=np.float64)
    if not np.isfinite(axis).all():
        raise Unreadable("a wavelength is not a number")
    counts = np.where(np.isfinite(told.shots), told.shots, np.nan)
    if not np.isfinite(counts).any():
        raise Unreadable("the spectrum has no numeric intensity")
    notes = list(told.notes)
    in_unit = unit or told.unit or "nm"
    if unit is None and in_unit != "nm":
        notes.append(f"wavelengths in {in_unit}, as the file says")
    shots = _ascending(in_nm(axis, in_unit), counts, notes)
    return _with_light(replace(shots, notes=tuple(notes)))


def _readout(raw: bytes, columns: tuple[str, ...] | None) -> Readout:
    for format in FORMATS:
        if format.begins(raw):
            if format is hdf5:
                return hdf5.read(raw, columns)
            if columns is not None:
                raise Unreadable(f"--columns is for text and HDF5; this is {format.NAME}")
            return format.read(raw)
    return read_text(raw, columns)


def _ascending(nm: FloatArray, counts: FloatArray, notes: list[str]) -> Shots:
    """In the order of wavelengths, equal ones averaged; stacked spectra become shots."""
    steps = np.diff(nm)
    if np.all(steps > 0):
        return Shots(nm, counts)
    if np.all(steps < 0):
        return Shots(nm[::-1].copy(), np.ascontiguousarray(counts[:, ::-1]))
    stacked = _stacked(nm, counts)
    if stacked is not None:
        notes.append(f"{len(stacked)} spectra stand one below the other")
        return stacked
    unique, row = np.unique(nm, return_inverse=True)
    if len(unique) < LEAST_DISTINCT * len(nm):
        raise Unreadable(
            f"{len(nm):,} rows have only {len(unique):,} different wavelengths, such as "
            f"{unique[0]:g}, so that their order is unknown; are decimals missing, or is this "
            "another column? Export them with more decimals, or say the columns with --columns"
        )
    if len(nm) > 3 and (np.all(steps[1:] > 0) or np.all(steps[1:] < 0)):
        raise Unreadable(
            f"the first line of numbers ({nm[0]:g}) is not in the order of those that follow "
            f"({nm[1]:g}, {nm[2]:g}, ...): is it a part of the header? Put # before it"
        )
    back = int(np.sum(steps < 0))
    if back > max(SOME_BACK * len(steps), 1) and np.sum(steps > 0) > max(SOME_BACK * len(steps), 1):
        notes.append("the rows were not in the order of their wavelengths, and were sorted")
    elif back and np.sum(steps > 0) > back:
        notes.append(f"the wavelengths go back at {back} places; the ranges overlap there")
    if len(unique) < len(nm):
        notes.append(f"{len(nm) - len(unique)} wavelengths occur again; their counts were averaged")
    good = np.isfinite(counts)
    mean = np.full((len(counts), len(unique)), np.nan)
    for shot, ok, out in zip(counts, good, mean, strict=True):
        total = np.bincount(row[ok], shot[ok], minlength=len(unique))
        count = np.bincount(row[ok], minlength=len(unique))
        np.divide(total, count, out=out, where=count > 0)
    return Shots(unique, mean)


def _stacked(nm: FloatArray, counts: FloatArray) -> Shots | None:
    """Shots of a text that repeats the same axis, None otherwise."""
    again = np.flatnonzero(nm == nm[0])
    n = len(nm) // len(again)
    if len(counts) > 1 or len(again) < 2 or n < 2 or len(nm) != n * len(again):
        return None
    axes = nm.reshape(-1, n)
    if not np.all(axes == axes[0]) or not np.all(np.diff(axes[0]) > 0):
        return None
    return Shots(axes[0].copy(), counts.reshape(-1, n))


def _with_light(shots: Shots) -> Shots:
    """Without shots of one value throughout. Raises Unreadable if none is left."""
    low = np.where(np.isfinite(shots.intensity), shots.intensity, np.inf).min(axis=1)
    high = np.where(np.isfinite(shots.intensity), shots.intensity, -np.inf).max(axis=1)
    level = (low > high) | (low == high) & ((low == 0) | (shots.intensity.shape[1] > 2))
    if not level.any():
        return shots
    if level.all():
        value = float(low[np.isfinite(low)][0])
        if value == 0:
            raise Unreadable("every intensity is 0: the detector was not read out")
        raise Unreadable(f"every intensity is {value:g}: is this the column of counts?")
    left = f"{int(level.sum())} of {len(shots)} shots have one value throughout; left out"
    return Shots(shots.wavelength_nm, shots.intensity[~level], (*shots.notes, left))
