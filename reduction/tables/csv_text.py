"""The lines of a CSV file from Arrow's columns: RFC 4180, quotes only where they are needed."""

from pathlib import Path
from types import TracebackType
from typing import Any

import pyarrow as pa
import pyarrow.compute

pc: Any = pyarrow.compute  # its functions are created on import
NEEDS_QUOTES = r'[",\r\n]'


def csv_lines(table: pa.Table) -> bytes:
    """One line per row, without a header; empty cells for nulls, shortest exact numbers."""
    if not len(table):
        return b""
    cells = [_cells(column.combine_chunks()) for column in table.columns]
    lines = pc.binary_join_element_wise(*cells, ",")
    together = pc.binary_join(pa.ListArray.from_arrays([0, len(lines)], lines), "\n")
    return together[0].as_buffer().to_pybytes() + b"\n"


def _cells(column: pa.Array) -> pa.Array:
    if not pa.types.is_string(column.type):
        return pc.fill_null(pc.cast(column, pa.string()), "")
    column = pc.fill_null(column, "")
    odd = pc.match_substring_regex(column, NEEDS_QUOTES)
    if not pc.any(odd).as_py():
        return column
    inside = pc.replace_substring(column, '"', '""')
    return pc.if_else(odd, pc.binary_join_element_wise('"', inside, '"', ""), column)


class CsvFile:
    """A CSV file written table by table."""

    def __init__(self, path: Path, schema: pa.Schema) -> None:
        self.file = path.open("wb")
        self.file.write((",".join(schema.names) + "\n").encode())

    def write_table(self, table: pa.Table) -> None:
        self.file.write(csv_lines(table))

    def __enter__(self) -> "CsvFile":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        fault: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.file.close()
