"""Parquet and Feather, read by pyarrow: a table of columns, or of spectra in rows, as text is."""

from io import BytesIO

from ..readout import Readout
from ..text import read_text
from .library import library, spoiled

NAME = "a Parquet or Feather table"
LIBRARY = "pyarrow"
PARQUET, FEATHER = b"PAR1", b"ARROW1"


def begins(raw: bytes) -> bool:
    return raw.startswith((PARQUET, FEATHER))


def read(raw: bytes, columns: tuple[str, ...] | None = None) -> Readout:
    library(LIBRARY, NAME)
    from pyarrow import csv, feather, parquet

    text = BytesIO()
    try:
        of = parquet if raw.startswith(PARQUET) else feather
        csv.write_csv(of.read_table(BytesIO(raw)), text)
    except Exception as fault:  # damaged files raise OSError, columns of lists ArrowInvalid
        raise spoiled(NAME, fault) from fault
    return read_text(text.getvalue(), columns)
