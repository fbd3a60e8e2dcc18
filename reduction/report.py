"""Make the element maps of a run from the rows that it collected."""

import csv
import math
from pathlib import Path

import numpy as np

from .maps import ElementMap, element_map
from .symbols import SYMBOLS

ROWS = "data*.csv"  # `data.csv`, and one for each further loop that collects
FIGURE = "element_maps{}.png"
LEAST_LINES = 2  # distinct x, and distinct y, below which there is nothing to map

Columns = dict[str, np.ndarray]


def make(folder: Path) -> list[Path]:
    """Draw the element maps of the run in `folder`; the files written, none if nothing is to map.

    Reads `data.csv` into `element_maps.png`, `data-NAME.csv` into `element_maps-NAME.png`:
    coordinates are the columns `x` and `y`, or `x_mm` and `y_mm` with their unit; elements are the
    columns that bear a chemical symbol. Empty cells are holes. Raises OSError when the figure
    cannot be written.
    """
    made = (_draw(folder, rows) for rows in sorted(folder.glob(ROWS)) if rows.is_file())
    return [path for path in made if path is not None]


def _draw(folder: Path, rows: Path) -> Path | None:
    maps, unit = maps_of(_columns(rows))
    if not maps:
        return None
    from .figure import draw_element_maps

    name = rows.stem.removeprefix("data")
    title = f"{folder.resolve().name} {name.lstrip('-')}".rstrip()
    return draw_element_maps(maps, folder / FIGURE.format(name), title=title, unit=unit)


def maps_of(columns: Columns) -> tuple[dict[str, ElementMap], str]:
    """The map of each element among the columns (shape (n,) each), and the coordinates' unit."""
    x_name, y_name = _coordinate(columns, "x"), _coordinate(columns, "y")
    if x_name is None or y_name is None:
        return {}, ""
    unit = x_name.partition("_")[2] or "mm"
    x, y = columns[x_name], columns[y_name]
    placed = np.isfinite(x) & np.isfinite(y)
    maps = {
        name: element_map(x[placed], y[placed], values[placed])
        for name, values in columns.items()
        if name in SYMBOLS and np.isfinite(values[placed]).any()
    }
    if any(min(found.values.shape) < LEAST_LINES for found in maps.values()):
        return {}, ""
    return maps, unit


def _coordinate(columns: Columns, axis: str) -> str | None:
    return next((name for name in columns if name == axis or name.startswith(f"{axis}_")), None)


def _columns(path: Path) -> Columns:
    """The columns of a CSV file as numbers, NaN for whatever is none."""
    with path.open(newline="", encoding="utf-8-sig") as file:
        rows = list(csv.reader(file))
    if not rows:
        return {}
    header, *body = rows
    return {
        name.strip(): np.array(
            [_number(row[index]) if index < len(row) else math.nan for row in body]
        )
        for index, name in enumerate(header)
    }


def _number(cell: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan
