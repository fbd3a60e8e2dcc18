"""Tables as Arrow knows them: typed columns, and bytes that travel between processes."""

from functools import cache

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


def batch_of(table: str, spectrum: str, cells: Cells) -> pa.RecordBatch:
    """The rows of one spectrum. Raises ValueError when the cells are not those of the table."""
    columns = TABLES[table]
    wanted = [column.name for column in columns[1:]]
    if list(cells) != wanted:
        raise ValueError(f"the cells of {table} are {wanted}, not {list(cells)}")
    arrays = [_array(column, cells[column.name]) for column in columns[1:]]
    name = pa.array([spectrum] * len(arrays[0]), TYPES["text"])
    return pa.RecordBatch.from_arrays([name, *arrays], schema=schema_of(table))


def _array(column: Column, values) -> pa.Array:
    if column.kind == "number":
        given = (
            values if isinstance(values, np.ndarray) else [NAN if v is None else v for v in values]
        )
        return pa.array(rounded(given, column), from_pandas=True)
    return pa.array(values, TYPES[column.kind])


def packed(batch: pa.RecordBatch) -> bytes:
    """The rows alone: whoever unpacks them knows the columns."""
    return batch.serialize().to_pybytes()


def unpacked(table: str, raw: bytes) -> pa.RecordBatch:
    """What `packed` packed."""
    return pa.ipc.read_record_batch(pa.py_buffer(raw), schema_of(table))
