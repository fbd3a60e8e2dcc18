"""Excel and LibreOffice (.xlsx, .xls, .ods), read by python-calamine: the sheet with numbers, as text is."""

from dataclasses import replace
from datetime import date, time
from io import BytesIO

from ..fault import Unreadable
from ..readout import Readout
from ..text import read_text
from .library import library, spoiled
from .zipped import first_name

NAME = "a spreadsheet"
LIBRARY = "python_calamine"
OLD, WORKBOOK = b"\xd0\xcf\x11\xe0", "Workbook".encode("utf-16-le")
PARTS = ("[Content_Types]", "_rels/", "xl/", "docProps/", "mimetype", "customXml/")
LEAST = 3  # rows of two numbers


def begins(raw: bytes) -> bool:
    return (raw.startswith(OLD) and WORKBOOK in raw) or first_name(raw).startswith(PARTS)


def read(raw: bytes, columns: tuple[str, ...] | None = None) -> Readout:
    calamine = library(LIBRARY, NAME)
    try:
        book = calamine.CalamineWorkbook.from_filelike(BytesIO(raw))
        sheets = {name: book.get_sheet_by_name(name).to_python() for name in book.sheet_names}
    except Exception as fault:  # what it raises has no common base
        raise spoiled(NAME, fault) from fault
    filled = {name: rows for name, rows in sheets.items() if sum(map(_numbers, rows)) >= LEAST}
    if len(filled) != 1:
        raise Unreadable(
            f"{NAME} with {len(filled) or 'no'} sheets of numbers ({', '.join(filled or sheets)}); "
            "save the one with the spectrum as CSV"
        )
    ((name, rows),) = filled.items()
    told = read_text("\n".join(map(_line, rows)).encode(), columns)
    more = (f"the sheet is {name!r}",) if len(sheets) > 1 else ()
    return replace(told, notes=(*more, *told.notes))


def _numbers(row: list[object]) -> bool:
    """Whether two cells are numbers, or in a row of words are written as such."""
    return sum(isinstance(cell, int | float) or str(cell)[:1].isdigit() for cell in row) >= 2


def _line(row: list[object]) -> str:
    return "\t".join(" ".join(_cell(cell).split()) for cell in row)


def _cell(cell: object) -> str:
    return cell.isoformat() if isinstance(cell, date | time) else str(cell)
