"""The tables of a run as arrays: numbers with their units, and the grid that x and y may be."""

from pathlib import Path
from typing import Any

import numpy as np

from ...schemas import journal as j
from ...schemas.quantity import is_quantity, magnitude_in
from ..journal.encode import decode
from ..journal.history import superseded
from ..journal.journal import Records
from ..run.folder import JOURNAL

AXES = ("y", "x")
LEAST_FULL = 0.5
"""Of a grid's points; with fewer of them x and y were chosen one by one."""
Table = dict[str, tuple[j.IterationEnded, dict[str, Any]]]
"""Key -> the record of an iteration and its row."""


def tables(folder: Path) -> dict[str, Table]:
    """Each table of a run that has rows, without rows that a later pass replaced."""
    records = Records(folder / JOURNAL)
    is_superseded = superseded(records)
    found: dict[str, Table] = {}
    for record in records.of("iteration"):
        if isinstance(record, j.IterationEnded) and record.row is not None:
            table: Table = found.setdefault(record.file.removesuffix(".csv") or "data", {})
            table.pop(record.row_key, None)
            if not is_superseded(record):
                table[record.row_key] = (record, decode(record.row))
    return {name: table for name, table in found.items() if table}


def numbers_of(values: list[Any]) -> tuple[np.ndarray, str] | None:
    """A column's numbers, NaN for none, and their unit; None where it has anything else."""
    unit = next((f"{value.units:~}" for value in values if is_quantity(value)), "")
    made = [magnitude_in(value, unit) if is_quantity(value) else value for value in values]
    if not all(one is None or (isinstance(one, int | float)) for one in made) or not any(
        one is not None for one in made
    ):
        return None
    return np.array([np.nan if one is None else float(one) for one in made]), unit


def grid_of(columns: list[np.ndarray]) -> list[tuple[np.ndarray, np.ndarray]] | None:
    """Of each axis its values, and where each row lies; None if the rows are no grid."""
    if not columns or not all(np.isfinite(column).all() for column in columns):
        return None
    axes = [np.unique(column, return_inverse=True) for column in columns]
    places = {tuple(place) for place in np.stack([at for _, at in axes], axis=1).tolist()}
    size = int(np.prod([len(values) for values, _ in axes]))
    return axes if len(places) == len(columns[0]) >= LEAST_FULL * size else None
