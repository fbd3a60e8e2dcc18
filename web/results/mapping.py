"""Columns over the plane: each table with x and y becomes maps that share one cell index."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from typing import Any

from ..models.results import MapHead
from .tables import BESIDE, Table

ELEMENT = re.compile(r"[A-Z][a-z]?")
LEAST = 2
REDUCTION = "labrun.reduction"


@dataclass(frozen=True)
class Plane:
    """The grid positions of a table's rows: `cell` of each row, -1 if it has none."""

    table: Table
    x: list[float]
    y: list[float]
    cell: Sequence[int]
    unit: str
    own: tuple[str, str]

    @cached_property
    def keys(self) -> list[str | None]:
        """The key of each cell; null if nothing was measured."""
        found: list[str | None] = [None] * (len(self.x) * len(self.y))
        for cell, key in zip(self.cell, self.table.columns.get("key", []), strict=False):
            if cell >= 0:
                found[cell] = key
        return found

    @property
    def columns(self) -> list[str]:
        """Columns that can be drawn: numbers that are neither coordinates nor keys."""
        return [n for n in self.table.numbers if n not in (*self.own, *BESIDE)]

    def values(self, column: str) -> Any:
        """Float32, shape (height * width,), row by row from the lowest y; NaN is a hole."""
        import numpy as np

        cells = np.array(self.cell)
        read = np.array([np.nan if v is None else v for v in self.table.numbers[column]])
        known = (cells >= 0) & np.isfinite(read)
        size = len(self.x) * len(self.y)
        total = np.bincount(cells[known], read[known], minlength=size)
        count = np.bincount(cells[known], minlength=size)
        mean = np.full(size, np.nan)
        np.divide(total, count, out=mean, where=count > 0)
        return mean.astype("<f4")

    def head(self, column: str) -> MapHead:
        """Sizes and the range of values."""
        import numpy as np

        values = self.values(column)
        known = values[np.isfinite(values)]
        ends = [None] * 4
        if len(known):
            ends = [float(v) for v in np.percentile(known.astype(float), [0, 100, 2, 98])]
        return MapHead(
            table=self.table.name, column=column, element=ELEMENT.fullmatch(column) is not None,
            unit=self.unit, width=len(self.x), height=len(self.y), x=self.x, y=self.y,
            measured=len(known), minimum=ends[0], maximum=ends[1], p2=ends[2], p98=ends[3],
        )  # fmt: skip


def plane_of(table: Table) -> Plane | None:
    """The positions of a table's rows; None without x and y, or if all are on one line or point."""
    x_name, y_name = _named(table, "x"), _named(table, "y")
    if x_name is None or y_name is None:
        return None
    import numpy as np

    x, y = (
        np.array([np.nan if v is None else v for v in table.numbers[name]], dtype=float)
        for name in (x_name, y_name)
    )
    placed = np.isfinite(x) & np.isfinite(y)
    if not placed.any():
        return None
    # Imported by name: reduction knows nothing of the page, but the page uses its grid.
    grid = import_module(REDUCTION).element_map(x[placed], y[placed], np.ones(placed.sum()))
    if min(len(grid.x), len(grid.y)) < LEAST:
        return None
    column = np.searchsorted(grid.x, np.round(x[placed], 6) - 1e-7)
    row = np.searchsorted(grid.y, np.round(y[placed], 6) - 1e-7)
    cell = np.full(len(x), -1, dtype=int)
    cell[placed] = row * len(grid.x) + column
    unit = x_name.partition("_")[2] or "mm"
    return Plane(table, grid.x.tolist(), grid.y.tolist(), cell.tolist(), unit, (x_name, y_name))


def _named(table: Table, axis: str) -> str | None:
    return next((n for n in table.numbers if n == axis or n.startswith(f"{axis}_")), None)
