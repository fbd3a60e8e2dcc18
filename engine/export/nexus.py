"""A run as NeXus (HDF5), which silx, HyperSpy, xarray and h5py open: tables and spectra with axes and units.

Each table is an NXdata group of its name, its spectra one beside it, NAME_spectra. Where its columns x
and y are a line or a grid, what was measured lies over them, NaN where a point is missing; else along
`row`, with x and y beside it. Axes are HDF5 dimension scales, too, as netCDF has them.
"""

import re
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ... import __version__
from ...schemas import journal as j
from ...system.extras import not_installed
from ...system.files import replace_whole
from ..journal.journal import JournalFault, Records
from ..run.folder import JOURNAL, FolderFault, protocol_file
from .formats import ExportFault
from .tables import AXES, grid_of, numbers_of, tables

SPECTRA = "spectra/"
WT_PERCENT = re.compile(
    r"_wt_percent(_err|_low|_high|_known)?$"
)  # columns whose names are their unit


def write(folder: Path, place: Path) -> None:
    """Write the run in `folder` to the file `place`; raises ExportFault and OSError."""
    try:
        found = tables(folder)
        with replace_whole(place) as out, h5py.File(out, "w") as file:
            entry = _group(file, "entry", "NXentry")
            file.attrs["default"] = "entry"
            for record in Records(folder / JOURNAL).of("started", "finished"):
                if isinstance(record, j.Started):
                    entry["title"], entry["entry_identifier"] = record.protocol, folder.name
                    entry["start_time"] = record.began or record.at
                elif isinstance(record, j.Finished):
                    entry.pop("end_time", None)
                    entry["end_time"] = record.at
            entry["program_name"] = "labrun"
            entry["program_name"].attrs["version"] = __version__
            note = _group(entry, "protocol", "NXnote")
            copy = protocol_file(folder)
            note["data"], note["file_name"] = copy.read_text(encoding="utf-8"), copy.name
            spectra, areas = _within(folder)
            for name, rows in found.items():
                _write_table(entry, name, list(rows.values()), folder, spectra, areas)
    except (JournalFault, FolderFault) as fault:
        raise ExportFault(str(fault)) from fault
    except ImportError as fault:
        raise ExportFault(not_installed(fault) or str(fault)) from fault


def _within(folder: Path) -> tuple[dict[str, str], dict[str, set[float]]]:
    """Path of a loop with the key of an iteration -> what came from within it: the newest spectrum, and the
    areas of peaks that a reducer told."""
    spectra: dict[str, str] = {}
    areas: dict[str, set[float]] = {}
    for record in Records(folder / JOURNAL).of("ended"):
        if not isinstance(record, j.GoalEnded):
            continue
        names = [name for name in record.files if name.startswith(SPECTRA)]
        told = (record.result or {}).get("areas")
        path = record.id.partition("/")[2]
        while path := path.rpartition("/")[0]:
            if names:
                spectra[path] = names[-1]
            if isinstance(told, dict):
                areas.setdefault(path, set()).update(v for v in told.values() if v)
    return spectra, areas


def _write_table(
    entry: Any, name: str, rows: list[tuple[j.IterationEnded, dict[str, Any]]], folder: Path,
    spectra: dict[str, str], areas: dict[str, set[float]],
) -> None:  # fmt: skip
    columns = list(dict.fromkeys(column for _, row in rows for column in row))
    numbers = {c: made for c in columns if (made := numbers_of([row.get(c) for _, row in rows]))}
    across = [a for a in AXES if a in numbers and len(np.unique(numbers[a][0])) > 1]
    grid = grid_of([numbers[axis][0] for axis in across])
    data = _group(entry, name, "NXdata")
    if grid is None:
        across, row = [], "row"
        while row in columns:
            row += "_"
        places: tuple[Any, ...] = (np.arange(len(rows)),)
        axes = [_axis(data, row, places[0], "")]
    else:
        places = tuple(at for _, at in grid)
        axes = [
            _axis(data, axis, values, numbers[axis][1])
            for axis, (values, _) in zip(across, grid, strict=True)
        ]
    shape = tuple(len(axis) for axis in axes)
    texts = {"key": [record.row_key for record, _ in rows], "fate": [r.fate for r, _ in rows]}
    for column in (column for column in columns if column not in across):
        if column in numbers:
            values, unit = np.full(shape, np.nan), numbers[column][1]
            values[places] = numbers[column][0]
            unit = unit or ("wt %" if WT_PERCENT.search(column) else "")
            if not unit and _are_areas(column, rows, areas):
                unit = "counts nm"
            _attach(data.create_dataset(column, data=values), axes, unit)
        else:
            texts[column] = ["" if (v := row.get(column)) is None else str(v) for _, row in rows]
    for column, words in texts.items():
        if column not in data:
            cells = np.full(shape, "", dtype=object)
            cells[places] = words
            _attach(data.create_dataset(column, data=cells, dtype=_text()), axes, "")
    signals = [column for column in columns if column in numbers and column not in AXES]
    _plot(data, signals[0] if signals else "", axes)
    entry.attrs.setdefault("default", name)
    files = [spectra.get(f"{record.loop}/{record.key}") for record, _ in rows]
    if any(files):
        _write_spectra(entry, f"{name}_spectra", folder, files, places, axes)


def _are_areas(
    column: str, rows: list[tuple[j.IterationEnded, dict[str, Any]]], areas: dict[str, set[float]]
) -> bool:
    """Whether each value of a column, but 0, is an area of its own iteration: protocols name columns."""
    own = [(f"{record.loop}/{record.key}", row[column]) for record, row in rows if row.get(column)]
    return bool(own) and all(value in areas.get(path, ()) for path, value in own)


def _write_spectra(
    entry: Any, name: str, folder: Path, files: list[str | None], places: tuple[Any, ...],
    axes: list[Any],
) -> None:  # fmt: skip
    from ... import read_spectrum  # type: ignore[attr-defined]

    data, counts, wavelength = None, None, np.empty(0)
    left_out: list[str] = []
    for row, file in enumerate(files):
        if file is None:
            continue
        try:
            spectrum = read_spectrum(folder / file)
        except (OSError, ValueError) as fault:
            left_out.append(f"{file}: {fault}")
            continue
        if counts is None:
            wavelength = spectrum.wavelength_nm
            data = _group(entry, name, "NXdata")
            along = [_axis(data, _name(one), one[()], one.attrs.get("units", "")) for one in axes]
            along.append(_axis(data, "wavelength", _evened(wavelength), "nm"))
            shape = tuple(len(one) for one in along)
            counts = data.create_dataset(
                "intensity", shape, "f4", fillvalue=np.nan, chunks=(*(1 for _ in axes), shape[-1]),
                compression="gzip", compression_opts=1, shuffle=True,
            )  # fmt: skip
            _attach(counts, along, "counts")
            _plot(data, "intensity", along)
        if not np.array_equal(spectrum.wavelength_nm, wavelength):
            left_out.append(f"{file}: other wavelengths")
            continue
        counts[tuple(int(at[row]) for at in places)] = spectrum.intensity
    if data is not None and left_out:
        data.attrs["left_out"] = left_out


def _evened(axis: np.ndarray) -> np.ndarray:
    """Evenly spaced, where it is but for the rounding of its decimals: else as it is.

    HyperSpy takes the axis of a file only if its first step is all of them, to 1e-5; instruments that
    write 190.0333, 190.0667 nm lost theirs.
    """
    decimals = next((n for n in range(9) if np.allclose(axis, axis.round(n), 0, 1e-10)), None)
    rounding = 10.0**-decimals if decimals is not None else 0.0
    if decimals is None and np.array_equal(axis, axis.astype("f4")):
        rounding = float(np.spacing(np.float32(axis[-1])))
    even = np.linspace(axis[0], axis[-1], axis.size)
    fine = axis.size > 1 and 3 * rounding <= (axis[-1] - axis[0]) / (axis.size - 1)
    return even if fine and np.abs(axis - even).max() <= 1.01 * rounding else axis


def _group(parent: Any, name: str, kind: str) -> Any:
    group = parent.create_group(name)
    group.attrs["NX_class"] = kind
    return group


def _axis(data: Any, name: str, values: np.ndarray, unit: str) -> Any:
    axis = data.create_dataset(name, data=values)
    axis.make_scale(name)
    if unit:
        axis.attrs["units"] = unit
    return axis


def _attach(dataset: Any, axes: list[Any], unit: str) -> None:
    for dimension, axis in zip(dataset.dims, axes, strict=True):
        dimension.attach_scale(axis)
    if unit:
        dataset.attrs["units"] = unit


def _plot(data: Any, signal: str, axes: list[Any]) -> None:
    data.attrs["axes"] = [_name(axis) for axis in axes]
    if signal:
        data.attrs["signal"] = signal
        for place in (data, data[signal]):  # HyperSpy looks for it at the group
            place.attrs["interpretation"] = "image" if len(axes) == 2 else "spectrum"


def _name(dataset: Any) -> str:
    return dataset.name.rpartition("/")[2]


def _text() -> Any:
    return h5py.string_dtype()
