"""HDF5 and NeXus: the default plot of the file, or the one axis of wavelengths and its counts."""

from io import BytesIO
from typing import Any

import numpy as np

from ..axis import Unit, unit_named
from ..readout import Readout
from .library import library, spoiled
from .named import chosen, only_table, readout

NAME = "an HDF5 file"
LIBRARY = "h5py"
MAGIC = b"\x89HDF\r\n\x1a\n"
USER_BLOCK = 512  # bytes, in which MATLAB 7.3 names itself


def begins(raw: bytes) -> bool:
    return raw.startswith(MAGIC) or raw.startswith(MAGIC, USER_BLOCK)


def read(raw: bytes, columns: tuple[str, ...] | None = None) -> Readout:
    """columns: the paths of the wavelengths and of the counts, if the file leaves a choice."""
    h5py = library(LIBRARY, NAME)
    try:
        with h5py.File(BytesIO(raw), "r") as file:
            plot = None if columns else _plot(h5py, file)
            there = {} if plot else _datasets(file)
            if not columns and not plot and (told := only_table(there)) is not None:
                return told
            axis, counts = plot or chosen(there, columns, NAME)
            unit: Unit | None = unit_named(_text(file[axis].attrs.get("units")))
            return readout((axis, file[axis]), (counts, file[counts]), unit)
    except (OSError, RuntimeError) as fault:
        raise spoiled(NAME, fault) from fault


def _plot(h5py: Any, file: Any) -> tuple[str, str] | None:
    """The paths of the wavelengths and the counts of the plot that the file says."""
    for group in _groups(h5py, file):
        signal = _text(group.attrs.get("signal"))
        axes = [_text(name) for name in np.atleast_1d(group.attrs.get("axes", []))]
        if axes and all(
            name in group and hasattr(group[name], "shape") for name in (signal, axes[-1])
        ):
            return group[axes[-1]].name, group[signal].name
    return None


def _groups(h5py: Any, file: Any) -> list[Any]:
    """The group that is the default plot, then every other, as NeXus says."""
    found: list[Any] = []
    at: Any = file
    while isinstance(at, h5py.Group):
        found.append(at)
        name = _text(at.attrs.get("default"))
        at = at.get(name) if name else None
    found.reverse()
    file.visititems(lambda _, one: found.append(one) if isinstance(one, h5py.Group) else None)
    return found


def _datasets(file: Any) -> dict[str, Any]:
    found: dict[str, Any] = {}

    def visit(name: str, one: Any) -> None:
        if hasattr(one, "shape") and one.dtype.kind in "fiu" and max(one.shape, default=0) > 1:
            found[name] = one

    file.visititems(visit)
    return found


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.flat[0]
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value or "")
