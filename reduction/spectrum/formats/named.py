"""Which of a file's named arrays are the wavelengths, and which the counts."""

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..axis import Unit, may_be_nm
from ..fault import Unreadable
from ..readout import Readout

AXIS = re.compile(r"wave|wv?l(\b|_|\d|$)|lambda|^nm$|^x$|^axis", re.I)
COUNTS = re.compile(r"intens|count|spectr|signal|^data$|^y$", re.I)
LEAST_SHOTS = 4  # of fewer, the first channel ascends by chance
SHOWN = 6  # arrays named in a refusal


def chosen(
    arrays: Mapping[str, Any], columns: tuple[str, ...] | None, what: str
) -> tuple[str, str]:
    """The names of both. columns: as they were asked for. Raises Unreadable where it would be a guess."""
    if columns is None:
        return _by_name(arrays, what)
    if len(columns) != 2:
        raise Unreadable(f"--columns of {what}: the names of two datasets, wavelengths first")
    names = [one.strip("/") for one in columns]
    for name, asked in zip(names, columns, strict=True):
        if name not in arrays:
            raise Unreadable(f"--columns: the file has no dataset {asked}; {_there(arrays)}")
    return names[0], names[1]


def readout(axis: tuple[str, Any], counts: tuple[str, Any], unit: Unit | None = None) -> Readout:
    """Of two named arrays, the wavelengths along any side of the counts."""
    values = np.squeeze(np.asarray(axis[1], np.float64))
    shots = np.squeeze(np.asarray(counts[1], np.float64))
    if values.ndim != 1 or len(values) not in shots.shape:
        raise Unreadable(
            f"{axis[0]} has the shape {values.shape} and {counts[0]} {shots.shape}: "
            "they share no length"
        )
    if shots.shape[-1] != len(values):
        shots = np.moveaxis(shots, shots.shape.index(len(values)), -1)
    return Readout(values, np.ascontiguousarray(shots).reshape(-1, len(values)), unit)


def only_table(arrays: Mapping[str, Any]) -> Readout | None:
    """The first row or column, and the others, of a file's one array; None where it does not ascend."""
    tables = [one for one in arrays.values() if len(one.shape) == 2 and min(one.shape) > 1]
    if len(arrays) != 1 or not tables:
        return None
    told = of_table(tables[0])
    return told if may_be_nm(told.axis) else None


def of_table(table: Any) -> Readout:
    """Of a table, its first row, or the first column of one that is higher than wide, and the others."""
    lying = np.asarray(table, np.float64)
    lying = lying if lying.shape[0] < lying.shape[1] else np.ascontiguousarray(lying.T)
    side = "row" if lying.shape == np.shape(table) else "column"
    other = "column" if side == "row" else "row"
    notes = ()
    if (
        len(lying) > LEAST_SHOTS
        and np.all(np.diff(lying[:, 0]) > 0)
        and np.all(np.diff(lying[0]) > 0)
    ):
        told = f"the first {side} of the table is read as the wavelengths; the first {other} ascends, too"
        notes = (f"{told}: if the wavelengths are there, transpose the table",)
    return Readout(lying[0], lying[1:], None, notes, wavelengths=False)


def _by_name(arrays: Mapping[str, Any], what: str) -> tuple[str, str]:
    axes = [name for name, one in arrays.items() if _long(one) and AXIS.search(_last(name))]
    if len(axes) == 1:
        n = max(arrays[axes[0]].shape)
        counts = [name for name, one in arrays.items() if name != axes[0] and n in one.shape]
        for some in (counts, [name for name in counts if COUNTS.search(_last(name))]):
            if len(some) == 1:
                return axes[0], some[0]
    raise Unreadable(
        f"this {what.partition(' ')[2]} does not say which datasets are wavelengths and counts; name both, "
        f"as in --columns /wavelength,/counts; {_there(arrays)}"
    )


def _long(one: Any) -> bool:
    """Whether it has one side only, or others of one, as a vector of MATLAB's."""
    return sum(n != 1 for n in one.shape) == 1


def _last(name: str) -> str:
    parts = name.split("/")
    return next((part for part in reversed(parts) if not part.isdecimal()), name)


def _there(arrays: Mapping[str, Any]) -> str:
    names = [f"/{name} {one.shape}" for name, one in arrays.items()]
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return f"it has {', '.join(names[:SHOWN]) or 'no dataset of numbers'}{more}"
