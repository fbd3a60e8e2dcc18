"""Read the tables of `labrun reduce`: peaks, elements, plasma, and the outcome of each file."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...spectrum.fault import Unreadable
from ...spectrum.spectrum import BoolArray, FloatArray, IntArray, TextArray
from .columns import Columns, read_columns
from .contents import Contents, of_spectra

WANTED = {
    "peaks": ("spectrum", "center_nm", "area", "area_err", "element"),
    "elements": ("spectrum", "element", "status", "area", "line_nm"),
    "plasma": ("spectrum", "temperature_k", "temperature_err", "log10_ne"),
    "files": ("spectrum", "status"),
}
PLACES = ("", "reduced")  # in the folder itself, or where `labrun reduce` puts them


@dataclass(frozen=True, slots=True, eq=False)
class Records:
    """Peaks or elements, a row each: `at` is the index of their spectrum; NaN where a cell is empty."""

    at: IntArray
    element: TextArray
    stage: TextArray
    centre_nm: FloatArray
    line_nm: FloatArray
    area: FloatArray
    area_error: FloatArray
    status: TextArray


@dataclass(frozen=True, slots=True, eq=False)
class Reduced:
    """The tables of reduced spectra; arrays of shape (n,) are in the order of `spectra`.

    failed: spectra that could not be reduced. peaks and elements are None where there is no such
    table, and so are the columns of the plasma NaN. contents: by element, of calibrated ones.
    """

    spectra: list[str]
    failed: BoolArray
    peaks: Records | None
    elements: Records | None
    temperature_k: FloatArray
    temperature_error_k: FloatArray
    log10_ne: FloatArray
    li_cation_fraction: FloatArray
    li_cation_fraction_error: FloatArray
    paths: list[Path]
    contents: dict[str, Contents] = field(default_factory=dict)


def read_reduced(folder: Path) -> Reduced | None:
    """The tables in `folder` or its `reduced/`, None if there are none.

    Raises Unreadable, with a sentence, for a table that is none or lacks a column.
    """
    tables = {}
    for name in WANTED:
        path = next((p for p in _places(folder, name) if p.is_file()), None)
        if path is not None:
            tables[name] = _checked(read_columns(path), name)
    if not tables:
        return None
    spectra: dict[str, int] = {}
    for table in tables.values():
        for spectrum in table.text("spectrum"):
            spectra.setdefault(spectrum.replace("\\", "/"), len(spectra))
    failed = np.zeros(len(spectra), dtype=bool)
    if "files" in tables:
        files = tables["files"]
        failed[_at(files, spectra)] = [status == "failed" for status in files.text("status")]
    plasma = tables.get("plasma")
    return Reduced(
        list(spectra), failed, _records(tables.get("peaks"), spectra),
        _records(tables.get("elements"), spectra), _spread(plasma, spectra, "temperature_k"),
        _spread(plasma, spectra, "temperature_err"), _spread(plasma, spectra, "log10_ne"),
        _spread(plasma, spectra, "li_cation_fraction"),
        _spread(plasma, spectra, "li_cation_fraction_err"),
        [table.path for table in tables.values()], _contents(tables.get("elements"), spectra),
    )  # fmt: skip


def _places(folder: Path, name: str) -> list[Path]:
    return [folder / place / f"{name}.csv" for place in PLACES]


def _checked(table: Columns, name: str) -> Columns:
    lacking = [column for column in WANTED[name] if column not in table]
    if lacking:
        raise Unreadable(
            f"{table.path} has no column {lacking[0]!r}: it is not a table that this version's "
            "`labrun reduce` writes; reduce the spectra again"
        )
    return table


def _at(table: Columns, spectra: dict[str, int]) -> IntArray:
    names = table.text("spectrum")
    return np.array([spectra[name.replace("\\", "/")] for name in names], dtype=np.int64)


def _spread(table: Columns | None, spectra: dict[str, int], name: str) -> FloatArray:
    values = np.full(len(spectra), np.nan)
    if table is not None:
        values[_at(table, spectra)] = table.numbers(name)
    return values


def _contents(table: Columns | None, spectra: dict[str, int]) -> dict[str, Contents]:
    return {} if table is None else of_spectra(table, _at(table, spectra), len(spectra))


def _records(table: Columns | None, spectra: dict[str, int]) -> Records | None:
    if table is None:
        return None
    line_nm = table.numbers("line_nm")
    return Records(
        _at(table, spectra),
        np.array(table.text("element"), dtype=str),
        np.array(table.text("stage"), dtype=str),
        table.numbers("center_nm") if "center_nm" in table else line_nm,
        line_nm,
        table.numbers("area"),
        table.numbers("area_err"),
        np.array(table.text("status"), dtype=str),
    )
