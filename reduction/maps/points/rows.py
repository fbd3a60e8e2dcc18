"""Find coordinates, samples and elements in the rows of a run: the columns of data.csv."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...lines.symbols import SYMBOLS
from ...spectrum.fault import Unreadable
from ...spectrum.spectrum import BoolArray, FloatArray
from .columns import Columns, read_columns
from .contents import Contents, of_rows

KEY, SAMPLE = "key", "sample"
STANDARD = "standard"  # a column of check standards, which are nowhere in a map


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
    """Rows of one table: x, y of shape (n,) in `unit`, NaN where there is no place.

    sample: of each row, '' where there is but one. area: element -> counts nm as the run collected
    it, NaN where the cell is empty; contents likewise. notes: sentences on what was odd.
    """

    columns: Columns
    x: FloatArray
    y: FloatArray
    unit: str
    sample: list[str]
    area: dict[str, FloatArray]
    contents: dict[str, Contents]
    notes: list[str]

    def __len__(self) -> int:
        return self.columns.n

    @property
    def placed(self) -> BoolArray:
        return np.isfinite(self.x) & np.isfinite(self.y)


def read_rows(path: Path) -> Rows:
    """The rows of a table of a run.

    Coordinates are `x` and `y`, or `x_mm` and `y_mm` with their unit; one of them alone is a line.
    Raises Unreadable for a table without rows or without coordinates.
    """
    columns = read_columns(path)
    if not columns.n:
        raise Unreadable(f"{path} has a header but no rows: nothing was measured")
    x_name, y_name = coordinate(columns, "x"), coordinate(columns, "y")
    named = [name for name in (x_name, y_name) if name is not None]
    if not named:
        raise Unreadable(
            f"{path} has no coordinates: a map needs the columns x and y, or x_mm and y_mm, "
            f"but its columns are {', '.join(columns.cells)}"
        )
    units = {name.partition("_")[2] for name in named}
    if len(units) > 1:
        raise Unreadable(f"{path} has {' and '.join(named)}, which are in different units")
    zero = np.zeros(columns.n)
    x = zero if x_name is None else columns.numbers(x_name)
    y = zero if y_name is None else columns.numbers(y_name)
    elements = [name for name in columns.cells if name in SYMBOLS]
    notes = [_odd(columns, name) for name in (*named, *elements) if columns.odd(name)]
    return Rows(
        columns, x, y, units.pop() or "mm", _samples(columns),
        {name: columns.numbers(name) for name in elements}, of_rows(columns), notes,
    )  # fmt: skip


def coordinate(columns: Columns, axis: str) -> str | None:
    """The column of an axis: its bare letter, or with a unit behind it."""
    return next(
        (name for name in columns.cells if name == axis or name.startswith(f"{axis}_")), None
    )


def _odd(columns: Columns, name: str) -> str:
    odd = columns.odd(name)
    cells = f"{len(odd)} cells that are" if len(odd) > 1 else "a cell that is"
    return f"{columns.path.name}: column {name} has {cells} not a number, such as {odd[0]!r}"


def _samples(columns: Columns) -> list[str]:
    """What the column `sample` says, else the key of the loop around (`A` in `A/0,0`).

    Numbers alone (`2/0,0`) are turns of a `while` or `repeat` over one and the same sample.
    """
    if SAMPLE in columns:
        return columns.text(SAMPLE)
    around = [key.rpartition("/")[0] for key in columns.text(KEY)]
    return [name if name.strip("0123456789/") else "" for name in around]
