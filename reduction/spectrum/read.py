"""Read spectra from the files of analysers and spectrometers, whatever their dialect.

What cannot be read with certainty is refused, with the line and the way on.
"""

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from .axis import NM_PER, Unit, in_nm
from .fault import Unreadable
from .formats import avantes, hdf5, jcamp, npy, sif, spc
from .formats.library import lacking
from .readout import Readout
from .shots import Shots
from .source import beginning_of, bytes_of, unpacked
from .spectrum import FloatArray, IntArray, Spectrum
from .text import read_text

FORMATS = (npy, hdf5, sif, spc, avantes, jcamp)
BY_LIBRARIES = (hdf5, sif, spc, avantes)
BEGINNING = 1024  # bytes, which tell what format a file has
LEAST_DISTINCT = 0.6  # of the wavelengths; fewer are not the axis of one spectrum
LEAST_ALIKE = 0.5  # median correlation of the roots of counts: shots of one sample have .9 and more
MOST_COMPARED, LEAST_CHANNELS, WITH_LINES = 50, 200, 5.0
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
    shots = read_shots(source, unit, columns)
    if columns is None:
        _check_of_one_sample(shots)
    return shots.mean()


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
        what = "wavelengths" if in_unit in NM_PER else "the axis is"
        notes.append(f"{what} in {in_unit}, as the file says")
    shots = _ascending(in_nm(axis, in_unit), counts, notes)
    return _with_light(replace(shots, notes=tuple(notes)))


def without_reader(paths: Iterable[Path]) -> dict[str, list[Path]]:
    """The files in a format whose library is not installed here, by the sentence that adds it.

    Only their beginnings are read, and nothing where every library is there.
    """
    found: dict[str, list[Path]] = {}
    absent = [(form, why) for form in BY_LIBRARIES if (why := lacking(form.LIBRARY, form.NAME))]
    for path in paths if absent else ():
        with suppress(OSError, Unreadable):  # it is told when it is read
            raw = beginning_of(path, BEGINNING)
            for why in (why for form, why in absent if form.begins(raw)):
                found.setdefault(why, []).append(path)
    return found


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
    if np.sum(steps < 0) > np.sum(steps > 0):
        nm, counts, steps = nm[::-1], counts[:, ::-1], -steps[::-1]
    back = int(np.sum(steps < 0))
    if back > max(SOME_BACK * len(steps), 1):
        notes.append("the rows were not in the order of their wavelengths, and were sorted")
    elif back:
        notes.append(f"the wavelengths go back at {back} places: {back + 1} ranges")
        kept = _ranges_kept(nm, steps)
        if kept is not None:
            if len(kept) < len(nm):
                notes.append("where two ranges overlap, each was used up to the middle")
            nm, counts = nm[kept], counts[:, kept]
    unique, row = np.unique(nm, return_inverse=True)
    if len(unique) < len(nm):
        notes.append(f"{len(nm) - len(unique)} wavelengths occur again; their counts were averaged")
    good = np.isfinite(counts)
    mean = np.full((len(counts), len(unique)), np.nan)
    for shot, ok, out in zip(counts, good, mean, strict=True):
        total = np.bincount(row[ok], shot[ok], minlength=len(unique))
        count = np.bincount(row[ok], minlength=len(unique))
        np.divide(total, count, out=out, where=count > 0)
    return Shots(unique, mean)


def _ranges_kept(nm: FloatArray, steps: FloatArray) -> IntArray | None:
    """Channels of the ranges of detectors or orders, ascending, none from two of them at one place.

    Sorted into each other, channels of different gain would be a saw's teeth. None where one range
    lies within another.
    """
    ranges = np.split(np.arange(len(nm)), np.flatnonzero(steps < 0) + 1)
    ranges.sort(key=lambda rows: nm[rows[0]])
    first, last = (np.array([nm[rows[end]] for rows in ranges]) for end in (0, -1))
    middle = 0.5 * (last[:-1] + first[1:])
    if np.any(np.diff(last) <= 0) or np.any(np.diff(middle) <= 0):
        return None
    low, high = [-np.inf, *middle], [*middle, np.inf]
    kept = [
        rows[(nm[rows] > a) & (nm[rows] <= b)]
        for rows, a, b in zip(ranges, low, high, strict=True)
    ]  # fmt: skip
    return np.concatenate(kept)


def _check_of_one_sample(shots: Shots) -> None:
    """Raise Unreadable for spectra that have little in common: their mean would be of nothing."""
    if len(shots) == 1:
        return
    light = np.nan_to_num(shots.intensity[:MOST_COMPARED])
    noise = (
        np.median(np.abs(np.diff(light, axis=1)), axis=1)
        if light.shape[1] > LEAST_CHANNELS
        else 0.0
    )
    light = light[light.std(axis=1) > WITH_LINES * noise]
    if len(light) < 2 or light.shape[1] <= LEAST_CHANNELS:
        return
    light = np.sqrt(light - light.min(axis=1, keepdims=True))
    alike = np.corrcoef(light)[np.triu_indices(len(light), 1)]
    if np.median(alike) < LEAST_ALIKE:
        raise Unreadable(
            f"the {len(shots)} spectra in it are too unlike one another to be shots of one sample "
            f"(correlation {np.median(alike):.2f}), so their mean is not taken; choose with --columns, "
            "or write a file for each"
        )


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
