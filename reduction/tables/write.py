"""Write tables as CSV and as Parquet."""

from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from itertools import islice
from pathlib import Path

import pyarrow.parquet

from .arrow import schema_of, table_of
from .columns import TABLES
from .csv_text import CsvFile
from .rows import Rows

TOGETHER = 256  # spectra in a row group: fixed, so that files do not depend on workers
COMPRESSION = "zstd"
THREADS = 4
Named = tuple[str, Rows]


def write_tables(spectra: Iterable[Named], folder: Path) -> list[Path]:
    """Write the tables of all spectra, in the order given, into `folder`; the files written.

    Each item is a spectrum's name and its rows by table; missing tables have none. The same rows give
    the same bytes, with the same version of Arrow. Raises OSError if they cannot be written.
    """
    with ExitStack() as opened, ThreadPoolExecutor(THREADS) as threads:
        sinks = {table: _sinks(table, folder, opened) for table in TABLES}
        for group in _groups(spectra):
            written = []
            for table, writers in sinks.items():
                rows = [(name, told[table]) for name, told in group if table in told]
                together = table_of(table, rows)
                if len(together):
                    written += [threads.submit(sink.write_table, together) for sink in writers]
            for one in written:
                one.result()
    return [folder / name for name in file_names()]


def file_names() -> list[str]:
    """The file names of the tables."""
    return [f"{table}{suffix}" for table in TABLES for suffix in (".csv", ".parquet")]


def _sinks(table: str, folder: Path, opened: ExitStack) -> tuple:
    schema, parquet = schema_of(table), folder / f"{table}.parquet"
    return (
        opened.enter_context(CsvFile(folder / f"{table}.csv", schema)),
        opened.enter_context(
            pyarrow.parquet.ParquetWriter(parquet, schema, compression=COMPRESSION)
        ),
    )


def _groups(spectra: Iterable[Named]) -> Iterator[list[Named]]:
    rest = iter(spectra)
    while group := list(islice(rest, TOGETHER)):
        yield group
