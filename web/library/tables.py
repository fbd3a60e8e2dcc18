"""Tables beside a protocol: the CSV files that it may name, and a new one."""

import re
from pathlib import Path

from ...engine.language.table import TableFault, table_of
from ...system.files import write_whole
from ..local.refusal import Refusal
from ..models.protocols import LARGEST_TEXT, CsvTable, NewCsvTable
from .names import place_of, wrong_name

SUFFIX = ".csv"
MOST_TABLES = 200
_NO_TEXT = re.compile("[\0-\x08\x0e-\x1f\ufffd]")  # what a browser makes of other bytes


def tables_beside(folder: Path, protocol: str) -> list[CsvTable]:
    """The tables in the folder of a protocol."""
    here = place_of(folder, protocol).parent
    found: list[CsvTable] = []
    for path in sorted(here.glob(f"*{SUFFIX}")):
        if path.is_file() and path.resolve().is_relative_to(folder.resolve()):
            found.append(_table(path))
        if len(found) >= MOST_TABLES:
            break
    return found


def bring_table(folder: Path, asked: NewCsvTable) -> CsvTable:
    """Write a table beside the protocol; raises Refusal if it is no table, or has no valid name."""
    here = place_of(folder, asked.protocol).parent
    stem = asked.name[: -len(SUFFIX)] if asked.name.lower().endswith(SUFFIX) else asked.name
    if "/" in stem or "'" in stem or wrong_name(f"{stem}.yaml"):
        raise Refusal(422, "WRONG_NAME", f"{asked.name[:80]!r} is not a valid name for a table")
    if _NO_TEXT.search(asked.text):
        reason = f"{asked.name} is not UTF-8 text: export the table as CSV in UTF-8"
        raise Refusal(422, "NO_TABLE", reason)
    try:
        data = asked.text.encode("utf-8")
        table_of(asked.name, asked.text)
    except (TableFault, UnicodeEncodeError) as fault:
        raise Refusal(422, "NO_TABLE", str(fault)) from fault
    for number in range(1, MOST_TABLES):
        path = here / f"{stem}{'' if number == 1 else f'_{number}'}{SUFFIX}"
        if not path.exists():
            write_whole(path, data)
        elif path.read_bytes() != data:
            continue
        return _table(path)
    raise Refusal(409, "EXISTS", f"too many tables are called {stem}: give it another name")


def _table(path: Path) -> CsvTable:
    try:
        if path.stat().st_size > LARGEST_TEXT:
            return CsvTable(name=path.name, rows=0, columns=[], fault=f"{path.name} is over 2 MB")
        table = table_of(path.name, path.read_text(encoding="utf-8-sig"))
    except (TableFault, OSError, UnicodeDecodeError) as fault:
        return CsvTable(name=path.name, rows=0, columns=[], fault=str(fault))
    names, kinds = [one.name for one in table.columns], [one.kind for one in table.columns]
    return CsvTable(name=path.name, rows=len(table), columns=names, kinds=kinds)
