"""The output of `labrun reduce` and `labrun map` in a run's folder, as tables with one row per point."""

import csv
from collections.abc import Iterable
from pathlib import Path

from .tables import Table, read_rows

PLASMA, MAPS, CLASSES = "reduced/plasma.csv", "maps/maps.csv", "maps/classes.csv"
SUMMARY = "maps/class_summary.csv"
NAMES = (PLASMA, MAPS, CLASSES, SUMMARY)
SPECTRUM = ("spectrum", "point")
"""The name of the column with the spectrum's file."""
NO_CLASS = "none"
Points = dict[str, tuple[str, str, str]]
"""Spectrum file -> key, x, y of its point, as texts."""


def reduced_names(folder: Path) -> list[str]:
    """The tables that exist."""
    return [name for name in NAMES if (folder / name).is_file()]


def places(spectra: Iterable[tuple[str, str | None]], collected: Iterable[Table]) -> Points:
    """The points of (file, key) pairs; their coordinates are in the rows that the run collected."""
    known: dict[str, tuple[str, str]] = {}
    for table in collected:
        x, y = (next((n for n in table.numbers if n.split("_")[0] == axis), "") for axis in "xy")
        if x and y and "key" in table.columns:
            rows = zip(*(table.columns[n] for n in ("key", x, y)), strict=True)
            known |= {key: (at_x, at_y) for key, at_x, at_y in rows}
    return {file: (key, *known.get(key, ("", ""))) for file, key in spectra if key is not None}


def read_reduced(folder: Path, name: str, points: Points) -> Table:
    """One table with the points' keys and coordinates in front; unchanged if it has no points."""
    columns = read_rows(folder / name)
    of = next((one for one in SPECTRUM if one in columns), None)
    if name == SUMMARY or of is None:
        return Table(name, columns)
    if name == MAPS:
        columns = _wide(columns)
    if name == CLASSES:
        columns["class"] = ["" if cell == NO_CLASS else cell for cell in columns["class"]]
    files = columns[of]
    x, y = (next((n for n in columns if n.startswith(f"{axis}_")), "") for axis in "xy")
    mine = [points.get(file, ("", "", "")) for file in files]
    first = {
        "key": [key for key, _, _ in mine],
        x or "x_mm": columns[x] if x else [at for _, at, _ in mine],
        y or "y_mm": columns[y] if y else [at for _, _, at in mine],
        "spectrum": files,
    }
    return Table(name, first | {n: c for n, c in columns.items() if n not in (of, x, y)})


def _wide(columns: dict[str, list[str]]) -> dict[str, list[str]]:
    """One row per point instead of one per point and element; areas by element."""
    head = [name for name in columns if name not in ("element", "line_nm", "value", "area_err")]
    head.remove("area")
    rows: dict[str, int] = {}
    wide: dict[str, list[str]] = {name: [] for name in head}
    areas: dict[str, dict[int, str]] = {}
    for i, (point, element) in enumerate(zip(columns["point"], columns["element"], strict=True)):
        if point not in rows:
            rows[point] = len(rows)
            for name in head:
                wide[name].append(columns[name][i])
        areas.setdefault(element, {})[rows[point]] = columns["area"][i]
    filled = {e: [by_row.get(at, "") for at in range(len(rows))] for e, by_row in areas.items()}
    return wide | filled


def csv_text(table: Table) -> str:
    """The table as CSV."""
    import io

    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(table.columns)
    writer.writerows(zip(*table.columns.values(), strict=True))
    return out.getvalue()
