"""Arrow tables: typed columns, made from the cells of many spectra at once."""

from collections.abc import Sequence
from functools import cache
from itertools import chain
from typing import Any

import numpy as np
import pyarrow as pa

from .columns import TABLES, Cells, Column
from .rounding import rounded

NAN = float("nan")
TYPES = {"text": pa.string(), "whole": pa.int64(), "number": pa.float64()}


@cache
def schema_of(table: str) -> pa.Schema:
    """The columns of a table; each number's unit is in its metadata."""
    return pa.schema([
        pa.field(c.name, TYPES[c.kind], metadata={"unit": c.unit} if c.unit else None)
        for c in TABLES[table]
    ])  # fmt: skip


def table_of(table: str, spectra: Sequence[tuple[str, Cells]]) -> pa.Table:
    """A table of the rows of spectra, each a name and its cells, in that order.

    Raises ValueError if the cells are not those of the table.
    """
    first, *columns = TABLES[table]
    wanted = [column.name for column in columns]
    for _, cells in spectra:
        if list(cells) != wanted:
            raise ValueError(f"the cells of {table} are {wanted}, not {list(cells)}")
    lengths = [len(cells[wanted[0]]) for _, cells in spectra]
    names = chain.from_iterable([name] * n for (name, _), n in zip(spectra, lengths, strict=True))
    arrays = [_array(column, [cells[column.name] for _, cells in spectra]) for column in columns]
    return pa.Table.from_arrays(
        [pa.array(list(names), TYPES[first.kind]), *arrays], schema=schema_of(table)
    )


def _array(column: Column, parts: Sequence[Any]) -> pa.Array:
    if column.kind == "number":
        values = np.concatenate([_numbers(part) for part in parts]) if parts else np.empty(0)
        return pa.array(rounded(values, column), from_pandas=True)
    return pa.array(list(chain.from_iterable(parts)), TYPES[column.kind])


def _numbers(values: Any) -> np.ndarray:
    if isinstance(values, np.ndarray):
        return values
    return np.array([NAN if value is None else value for value in values], dtype=np.float64)
