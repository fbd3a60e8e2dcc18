"""What `labrun reduce` and `labrun map` left in a run's folder, as tables with a row for each point."""

import csv
from collections.abc import Iterable
from pathlib import Path

from .tables import Table, read_rows

PLASMA, MAPS, CLASSES = "reduced/plasma.csv", "maps/maps.csv", "maps/classes.csv"
SUMMARY = "maps/class_summary.csv"
NAMES = (PLASMA, MAPS, CLASSES, SUMMARY)
SPECTRUM = ("spectrum", "point")
"""What the column with the spectrum's file is called."""
NO_CLASS = "none"
Points = dict[str, tuple[str, str, str]]
"""Spectrum file -> key, x, y of its point, as texts."""


def reduced_names(folder: Path) -> list[str]:
    """Those of the tables that are there."""
    return [name for name in NAMES if (folder / name).is_file()]


def places(spectra: Iterable[tuple[str, str | None]], collected: Iterable[Table]) -> Points:
    """The points of (file, key) pairs; where they lie stands in the rows that the run collected."""
    known: dict[str, tuple[str, str]] = {}
    for table in collected:
        x, y = (next((n for n in table.numbers if n.split("_")[0] == axis), "") for axis in "xy")
        if x and y and "key" in table.columns:
            rows = zip(*(table.columns[n] for n in ("key", x, y)), strict=True)
            known |= {key: (at_x, at_y) for key, at_x, at_y in rows}
    return {file: (key, *known.get(key, ("", ""))) for file, key in spectra if key is not None}


def read_reduced(folder: Path, name: str, points: Points) -> Table:
    """One table with the points' keys and places in front; one that has no points as it is."""
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
    told = {
        "key": [key for key, _, _ in mine],
        x or "x_mm": columns[x] if x else [at for _, at, _ in mine],
        y or "y_mm": columns[y] if y else [at for _, _, at in mine],
        "spectrum": files,
    }
    return Table(name, told | {n: c for n, c in columns.items() if n not in (of, x, y)})


def _wide(columns: dict[str, list[str]]) -> dict[str, list[str]]:
    """A row for each point instead of one for each point and element; its areas, by element."""
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
