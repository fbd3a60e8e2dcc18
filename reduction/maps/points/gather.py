"""Gather the points of a folder: the rows of its run, joined with the tables of its spectra."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...spectrum.fault import Unreadable
from ...spectrum.spectrum import FloatArray, IntArray
from ..checks import read_checks
from ..drift import corrected
from .columns import read_columns
from .contents import Contents, joined, taken
from .join import join
from .points import Points, merged
from .predominant import predominant_peaks
from .reduced import Reduced, read_reduced
from .rows import KEY, STANDARD, Rows, read_rows

ROWS = "data.csv"
MORE_ROWS = "data-*.csv"
SPECTRA = "spectra"


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """Rows of one table, with the index of each one's spectrum (-1: none)."""

    rows: Rows
    at: IntArray


def gather(folder: Path, *, tables: bool = True, correct_drift: bool = False) -> Points:
    """All that `folder` says about points: its data.csv (and data-NAME.csv), and reduced tables.

    Elements come from the tables where these have them, else from the rows; tables=False leaves
    them out. Concentrations are corrected by the run's check standards where that is asked for, here or
    in their rows. Raises Unreadable, with a sentence on what to do, where there is nothing to map.
    """
    if not folder.is_dir():
        raise Unreadable(
            f"{folder} is not a folder; `labrun map` needs a run's folder, or one of tables"
        )
    reduced = read_reduced(folder) if tables else None
    found, notes = _tables(folder)
    if not found and reduced is None:
        raise Unreadable("; ".join([*notes, _nothing(folder)]))
    if not found:
        notes.append("there are no rows with coordinates, so there are classes and no maps")
        return _from_spectra(reduced, notes) if reduced else _never()
    parts = [_part(rows, reduced, notes) for rows in found]
    if reduced is None:
        if not any(rows.area or rows.contents for rows in found):
            raise Unreadable(
                f"{found[0].columns.path} has no column of an element; " + _nothing(folder)
            )
        notes.append(_nothing(folder) + "; what the rows hold themselves is drawn")
    elif all((part.at < 0).all() for part in parts):
        if not any(rows.area or rows.contents for rows in found):
            return _from_spectra(reduced, notes)
        reduced = None
    return merged(_of_drift(_together(parts, reduced, notes), parts, folder, correct_drift))


def _of_drift(points: Points, parts: list[_Part], folder: Path, asked: bool) -> Points:
    """The points with concentrations corrected by check standards, if that is asked for."""
    checks = read_checks(folder)
    if not (asked or any(one.correct for one in checks)):
        return points
    if not (checks and points.contents and len(parts) == 1):
        why = (
            "the points are in several tables" if len(parts) > 1 else "no concentrations of points"
        )
        why = why if checks else "no rows of check standards"
        return replace(points, notes=[*points.notes, f"not corrected for drift: {why}"])
    contents, said = corrected(points.contents, np.arange(len(points), dtype=np.float64), checks)
    return replace(points, contents=contents, notes=[*points.notes, *said])


def _never() -> Points:
    raise AssertionError("neither rows nor tables: said before")


def _tables(folder: Path) -> tuple[list[Rows], list[str]]:
    """The tables of rows that have places; a sentence for each that has none."""
    found, notes = [], []
    for path in [folder / ROWS, *sorted(folder.glob(MORE_ROWS))]:
        if path.is_file():
            try:
                found.append(read_rows(path))
            except Unreadable as fault:
                if not _of_checks(path):
                    notes.append(str(fault))
    for rows in found:
        notes += rows.notes
        lost = int(np.sum(~rows.placed))
        if lost:
            notes.append(f"{rows.columns.path.name}: {lost} of {len(rows)} rows have no place")
    return [rows for rows in found if rows.placed.any()], notes


def _of_checks(path: Path) -> bool:
    try:
        return STANDARD in read_columns(path)
    except Unreadable:
        return False


def _nothing(folder: Path) -> str:
    spectra = folder / SPECTRA
    n = sum(1 for path in spectra.iterdir() if path.is_file()) if spectra.is_dir() else 0
    if n:
        return f"{n} files in {spectra} are not reduced yet: `labrun reduce {folder}` makes their tables"
    return (
        f"{folder} has neither {ROWS} nor the tables of `labrun reduce` "
        "(peaks.csv, elements.csv, plasma.csv)"
        if not (folder / ROWS).is_file()
        else f"{folder} has no tables of `labrun reduce` (peaks.csv, elements.csv, plasma.csv)"
    )


def _part(rows: Rows, reduced: Reduced | None, notes: list[str]) -> _Part:
    if reduced is None:
        return _Part(rows, np.full(len(rows), -1))
    at, how = join(rows.columns, reduced.spectra)
    name, table = rows.columns.path.name, reduced.paths[0].name
    if not how:
        notes.append(
            f"no row of {name} names one of the {len(reduced.spectra)} spectra in {table} (such as "
            f"{reduced.spectra[0]}); compared were all columns with the file names, and the key "
            f"with their ends; so {_instead(rows)}"
        )
    else:
        n = sum(place >= 0 for place in at)
        notes.append(f"{n} of {len(rows)} rows of {name} were joined to spectra by {how}")
    return _Part(rows, np.array(at, dtype=np.int64))


def _instead(rows: Rows) -> str:
    """What is drawn where rows and spectra could not be joined."""
    if rows.area or rows.contents:
        return "what the rows hold themselves is drawn"
    return "there are classes of the spectra, and no maps"


def _from_spectra(reduced: Reduced, notes: list[str]) -> Points:
    """Points without places: every spectrum of the tables."""
    n = len(reduced.spectra)
    nowhere = np.full(n, np.nan)
    return _with_tables(
        list(reduced.spectra),
        [""] * n,
        nowhere,
        nowhere,
        "mm",
        np.arange(n),
        {},
        {},
        reduced,
        notes,
        [],
    )


def _together(parts: list[_Part], reduced: Reduced | None, notes: list[str]) -> Points:
    several = len(parts) > 1
    name = [n for part in parts for n in _names(part, reduced)]
    sample = [
        " ".join(filter(None, (_table_name(part.rows) if several else "", one)))
        for part in parts
        for one in part.rows.sample
    ]
    if len({part.rows.unit for part in parts}) > 1:
        raise Unreadable("the tables of the run have coordinates in different units")
    elements = sorted({element for part in parts for element in part.rows.area})
    area = {
        e: np.concatenate([_collected(part.rows, e) for part in parts]) for e in elements
    }  # fmt: skip
    at = np.concatenate([part.at for part in parts])
    x, y = (np.concatenate([getattr(part.rows, axis) for part in parts]) for axis in "xy")
    inputs = [part.rows.columns.path for part in parts]
    unit = parts[0].rows.unit
    calibrated = sorted({element for part in parts for element in part.rows.contents})
    contents = {
        e: joined([(part.rows.contents.get(e), len(part.rows)) for part in parts])
        for e in calibrated
    }
    return _with_tables(name, sample, x, y, unit, at, area, contents, reduced, notes, inputs)


def _table_name(rows: Rows) -> str:
    return rows.columns.path.stem.partition("-")[2]


def _names(part: _Part, reduced: Reduced | None) -> list[str]:
    keys = part.rows.columns.text(KEY)
    return [
        reduced.spectra[at] if reduced is not None and at >= 0 else keys[row] or str(row + 1)
        for row, at in enumerate(part.at)
    ]


def _collected(rows: Rows, element: str) -> FloatArray:
    area = rows.area.get(element)
    return np.full(len(rows), np.nan) if area is None else area


def _with_tables(
    name, sample, x, y, unit, at, area, contents: dict[str, Contents], reduced: Reduced | None, notes,
    inputs,
) -> Points:  # fmt: skip
    n = len(name)
    nothing = np.full(n, np.nan)
    if reduced is None:
        return Points(
            name, sample, x, y, unit, area, dict.fromkeys(area, nothing), {}, nothing, nothing,
            nothing, nothing, np.full(n, -1), None, notes, inputs, contents,
        )  # fmt: skip
    found = predominant_peaks(reduced)
    from_tables = {e: _spread(peak.area, at) for e, peak in found.items()}
    errors = {e: _spread(peak.area_error, at) for e, peak in found.items()}
    only_rows = [e for e in area if e not in found]
    if only_rows:
        notes.append(f"{', '.join(only_rows)}: not in the tables, so as the run collected it")
    if reduced.failed.any():
        notes.append(
            f"{int(reduced.failed.sum())} spectra could not be reduced; files.csv says why"
        )
    return Points(
        name, sample, x, y, unit,
        {**area, **from_tables}, {**dict.fromkeys(area, nothing), **errors},
        {e: peak.line_nm for e, peak in found.items()}, _spread(_total(reduced), at),
        _spread(reduced.temperature_k, at), _spread(reduced.temperature_error_k, at),
        _spread(reduced.log10_ne, at), at, reduced, notes, [*inputs, *reduced.paths],
        contents | {e: taken(one, at) for e, one in reduced.contents.items()},
    )  # fmt: skip


def _spread(values: FloatArray, at: IntArray) -> FloatArray:
    """Values of spectra at the points that have one, NaN at the others."""
    return np.where(at >= 0, values[at], np.nan)


def _total(reduced: Reduced) -> FloatArray:
    """Area of all peaks of each spectrum, counts nm; NaN without a table of peaks."""
    if reduced.peaks is None:
        return np.full(len(reduced.spectra), np.nan)
    area = np.nan_to_num(reduced.peaks.area).clip(0)
    total = np.bincount(reduced.peaks.at, area, len(reduced.spectra))
    return np.where(reduced.failed, np.nan, total)
