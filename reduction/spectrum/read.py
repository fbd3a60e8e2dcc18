"""Read spectra from the files of analysers and spectrometers, whatever their dialect.

What cannot be read with certainty is refused, with the line and the way on.
"""

import itertools
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from .axis import NM_PER, Unit, check_unsaid, in_nm
from .columns import MOST_SHARED
from .fault import Unreadable
from .formats import (
    arrow,
    avantes,
    avantes7,
    hdf5,
    jcamp,
    mat,
    npy,
    procspec,
    sif,
    spc,
    spe,
    spreadsheet,
)  # fmt: skip
from .formats.library import lacking
from .interleaved import taken_apart
from .readout import Readout
from .shots import Shots
from .source import beginning_of, bytes_of, unpacked
from .spectrum import FloatArray, IntArray, Spectrum
from .text import read_text

FORMATS = (
    npy, mat, hdf5, arrow, spreadsheet, procspec, sif, spe, avantes7, spc, avantes, jcamp,
)  # fmt: skip
WITH_COLUMNS = {hdf5, mat, arrow, spreadsheet}
BY_LIBRARIES = (hdf5, sif, spc, avantes, spreadsheet)
BEGINNING = 1024  # bytes, which tell what format a file has
LEAST_DISTINCT = 0.6  # of the wavelengths; fewer are not the axis of one spectrum
LEAST_ALIKE = 0.5  # median correlation of the roots of counts: shots of one sample have .9 and more
MOST_COMPARED, LEAST_CHANNELS, WITH_LINES = 50, 200, 5.0
DARK = 0.1  # of the usual spread of counts
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
    return (of_one_sample(shots) if columns is None else shots).mean()


def read_shots(
    source: Path | str | bytes, unit: Unit | None = None, columns: Sequence[str] | None = None
) -> Shots:
    """The shots in a file, as `read_spectrum` reads them, one by one."""
    raw = unpacked(bytes_of(source))
    told = _readout(raw, None if columns is None else tuple(columns))
    notes = list(told.notes)
    axis, counts = _with_wavelengths(np.asarray(told.axis, np.float64), told.shots, notes)
    good = np.isfinite(counts)
    if not good.all():
        counts = np.where(good, counts, np.nan)
    if not good.any():
        raise Unreadable("the spectrum has no numeric intensity")
    in_unit = unit or told.unit or "nm"
    if unit is None and in_unit != "nm":
        what = "wavelengths" if in_unit in NM_PER else "the axis is"
        notes.append(f"{what} in {in_unit}, as the file says")
    said = unit is not None or told.unit is not None
    shots = _ascending(in_nm(axis, in_unit, said), counts, notes)
    if not said:
        check_unsaid(shots.wavelength_nm, told.wavelengths)
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
            if format in WITH_COLUMNS:
                return format.read(raw, columns)
            if columns is not None:
                raise Unreadable(
                    f"--columns is for tables and named datasets; this is {format.NAME}"
                )
            return format.read(raw)
    return read_text(raw, columns)


def _with_wavelengths(
    axis: FloatArray, counts: FloatArray, notes: list[str]
) -> tuple[FloatArray, FloatArray]:
    """Without channels at the ends that have none, as pixels beyond a spectrograph's range."""
    finite = np.isfinite(axis)
    if finite.all() and len(axis):
        return axis, counts
    known = np.flatnonzero(finite)
    if not len(known) or len(known) < known[-1] - known[0] + 1:
        raise Unreadable(
            "a wavelength is not a number; are these the columns of the spectrum? Say which with --columns"
        )
    if len(known) < len(axis):
        notes.append(f"{len(axis) - len(known)} channels at the ends have no wavelength; left out")
    inside = slice(known[0], known[-1] + 1)
    return axis[inside], counts[:, inside]


def _ascending(nm: FloatArray, counts: FloatArray, notes: list[str]) -> Shots:
    """In the order of wavelengths, equal ones averaged; stacked spectra become shots."""
    steps = np.diff(nm)
    if len(steps) and steps[0] < 0 and np.all(steps < 0):
        nm, counts, steps = nm[::-1].copy(), np.ascontiguousarray(counts[:, ::-1]), -steps[::-1]
    ascending = bool(np.all(steps > 0))
    if not ascending:
        stacked = _stacked(nm, counts)
        if stacked is not None:
            notes.append(f"{len(stacked)} spectra stand one below the other")
            return stacked
        nm, counts = _sorted(nm, counts, notes)
    kept, overlaps, more = taken_apart(nm, counts)
    if overlaps:
        where = ", ".join(f"{a:.1f} to {b:.1f}" for a, b in overlaps)
        notes.append(
            f"channels of two detectors had been sorted into one another ({where} nm); each was used up "
            "to the middle"
        )
        nm, counts = nm[kept], counts[:, kept]
    if more:
        notes.append(
            "many channels stand closer together than those beside them, as where overlapping detectors "
            "or orders were sorted into one another: export these one after the other"
        )
    return Shots(nm, counts) if ascending else _once(nm, counts, notes)


def _sorted(nm: FloatArray, counts: FloatArray, notes: list[str]) -> tuple[FloatArray, FloatArray]:
    """Wavelengths that do not go back, with their counts."""
    n_unique, steps = len(np.unique(nm)), np.diff(nm)
    if n_unique < LEAST_DISTINCT * len(nm):
        raise Unreadable(
            f"{len(nm):,} rows have only {n_unique:,} different wavelengths, such as "
            f"{nm.min():g}, so that their order is unknown; are decimals missing, or is this "
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
        _check_ranges(nm, steps)
        notes.append(f"the wavelengths go back at {back} places: {back + 1} ranges")
        kept = _ranges_kept(nm, steps)
        if kept is not None:
            if len(kept) < len(nm):
                notes.append("where two ranges overlap, each was used up to the middle")
            nm, counts = nm[kept], counts[:, kept]
    order = np.argsort(nm, kind="stable")
    return nm[order], counts[:, order]


def _once(nm: FloatArray, counts: FloatArray, notes: list[str]) -> Shots:
    """Equal wavelengths averaged. nm: ascending."""
    if np.all(np.diff(nm) > 0):
        return Shots(nm, counts)
    unique, row = np.unique(nm, return_inverse=True)
    notes.append(f"{len(nm) - len(unique)} wavelengths occur again; their counts were averaged")
    good = np.isfinite(counts)
    mean = np.full((len(counts), len(unique)), np.nan)
    for shot, ok, out in zip(counts, good, mean, strict=True):
        total = np.bincount(row[ok], shot[ok], minlength=len(unique))
        count = np.bincount(row[ok], minlength=len(unique))
        np.divide(total, count, out=out, where=count > 0)
    return Shots(unique, mean)


def _check_ranges(nm: FloatArray, steps: FloatArray) -> None:
    """Raise Unreadable where two ranges are of the same light: they are two spectra."""
    ends = sorted((part[0], part[-1]) for part in np.split(nm, np.flatnonzero(steps < 0) + 1))
    most = max(min(one[1], two[1]) - two[0] for one, two in itertools.pairwise(ends))
    if most > MOST_SHARED * float(np.ptp(nm)):
        raise Unreadable(
            f"{len(ends)} spectra stand one below the other, each with wavelengths of its own over the same "
            "range; write a file for each"
        )


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


def of_one_sample(shots: Shots) -> Shots:
    """Shots whose mean is of something: without those that show no lines where others do.

    Raises Unreadable for spectra that have little in common.
    """
    if len(shots) == 1 or len(shots.wavelength_nm) <= LEAST_CHANNELS:
        return shots
    light = np.nan_to_num(shots.intensity)
    spread = light.std(axis=1)
    lines = spread > WITH_LINES * np.median(np.abs(np.diff(light, axis=1)), axis=1)
    light = light[lines][:MOST_COMPARED]
    if not len(light):
        return shots
    if len(light) > 1:
        light = np.sqrt(light - light.min(axis=1, keepdims=True))
        alike = np.median(np.corrcoef(light)[np.triu_indices(len(light), 1)])
        if alike < LEAST_ALIKE:
            raise Unreadable(
                f"the {len(shots)} spectra in it are too unlike one another to be shots of one sample "
                f"(correlation {alike:.2f}), so their mean is not taken; choose with --columns, "
                "or write a file for each"
            )
    dark = ~lines & (spread < DARK * np.median(spread[lines]))
    if not dark.any():
        return shots
    note = f"{int(dark.sum())} of {len(shots)} columns or shots show no lines, as a dark spectrum; left out"
    return Shots(shots.wavelength_nm, shots.intensity[~dark], (*shots.notes, note))


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
    begins = shots.intensity[:, :2]
    if np.isfinite(begins).all() and np.all(begins[:, 0] != begins[:, -1]):
        return shots
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
