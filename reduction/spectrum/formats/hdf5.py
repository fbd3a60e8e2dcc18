"""HDF5 and NeXus: the default plot of the file, or the one axis of wavelengths and its counts."""

import re
from io import BytesIO
from typing import Any

import numpy as np

from ..axis import Unit, unit_named
from ..fault import Unreadable
from ..readout import Readout
from .library import library, spoiled

NAME = "an HDF5 file"
LIBRARY = "h5py"
MAGIC = b"\x89HDF\r\n\x1a\n"
AXIS = re.compile(r"wave|lambda|^wl|^nm$|^x$|^axis", re.I)
COUNTS = re.compile(r"intens|count|spectr|signal|^data$|^y$", re.I)
SHOWN = 6  # datasets named in a refusal


def begins(raw: bytes) -> bool:
    return raw.startswith(MAGIC)


def read(raw: bytes, columns: tuple[str, ...] | None = None) -> Readout:
    """columns: the paths of the wavelengths and of the counts, if the file leaves a choice."""
    h5py = library(LIBRARY, NAME)
    try:
        with h5py.File(BytesIO(raw), "r") as file:
            axis, counts = _named(file, columns) if columns else _plot(h5py, file)
            return _readout(axis, counts)
    except (OSError, RuntimeError) as fault:
        raise spoiled(NAME, fault) from fault


def _named(file: Any, columns: tuple[str, ...]) -> tuple[Any, Any]:
    if len(columns) != 2:
        raise Unreadable("--columns of an HDF5 file: the paths of two datasets, wavelengths first")
    for path in columns:
        if path not in file or not hasattr(file[path], "shape"):
            raise Unreadable(
                f"--columns: the file has no dataset {path}; {_there(_datasets(file))}"
            )
    return file[columns[0]], file[columns[1]]


def _plot(h5py: Any, file: Any) -> tuple[Any, Any]:
    for group in _groups(h5py, file):
        signal = _text(group.attrs.get("signal"))
        axes = [_text(name) for name in np.atleast_1d(group.attrs.get("axes", []))]
        if axes and all(
            name in group and hasattr(group[name], "shape") for name in (signal, axes[-1])
        ):
            return group[axes[-1]], group[signal]
    return _by_name(_datasets(file))


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


def _by_name(datasets: dict[str, Any]) -> tuple[Any, Any]:
    def last(name: str) -> str:
        parts = name.split("/")
        return next((part for part in reversed(parts) if not part.isdecimal()), name)

    axes = [one for name, one in datasets.items() if one.ndim == 1 and AXIS.search(last(name))]
    if len(axes) == 1:
        n = len(axes[0])
        counts = {k: v for k, v in datasets.items() if v.name != axes[0].name and n in v.shape}
        said = {name: one for name, one in counts.items() if COUNTS.search(last(name))}
        for some in (counts, said):
            if len(some) == 1:
                return axes[0], next(iter(some.values()))
    raise Unreadable(
        "this HDF5 file does not say which datasets are wavelengths and counts; name both, as in "
        f"--columns /wavelength,/counts; {_there(datasets)}"
    )


def _there(datasets: dict[str, Any]) -> str:
    names = [f"/{name} {one.shape}" for name, one in datasets.items()]
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return f"it has {', '.join(names[:SHOWN]) or 'no dataset of numbers'}{more}"


def _readout(axis: Any, counts: Any) -> Readout:
    values, shots = np.asarray(axis, np.float64), np.asarray(counts, np.float64)
    if values.ndim != 1 or len(values) not in shots.shape:
        raise Unreadable(
            f"{axis.name} has the shape {values.shape} and {counts.name} {shots.shape}: "
            "they share no length"
        )
    if shots.shape[-1] != len(values):
        shots = np.moveaxis(shots, shots.shape.index(len(values)), -1)
    unit: Unit | None = unit_named(_text(axis.attrs.get("units")))
    return Readout(values, np.ascontiguousarray(shots).reshape(-1, len(values)), unit)


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.flat[0]
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value or "")
