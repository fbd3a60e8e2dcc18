"""Lines from a CSV file, beside those of the shipped table: of one's own, or as NIST exports them."""

import csv
import math
from collections.abc import Mapping

import numpy as np

from .air import to_vacuum
from .symbols import SYMBOLS
from .table import LineTable

HC_EV_NM = 1239.8419843  # h c (CODATA 2018, exact)
UNLIKE = 0.002  # share by which wavelength and levels may differ, rounding included

# What each column may be called: labrun's name first, then those of an export from NIST's ASD.
NAMES = {
    "element": ("element",),
    "stage": ("stage", "sp_num"),
    "vacuum_nm": ("wavelength_vacuum_nm", "ritz_wl_vac(nm)", "obs_wl_vac(nm)"),
    "air_nm": ("wavelength_air_nm", "ritz_wl_air(nm)", "obs_wl_air(nm)"),
    "a_ki_per_s": ("a_ki_per_s", "Aki(s^-1)"),
    "g_i": ("g_i",),
    "g_k": ("g_k",),
    "e_i_ev": ("e_i_ev", "Ei(eV)"),
    "e_k_ev": ("e_k_ev", "Ek(eV)"),
    "accuracy": ("accuracy", "Acc"),
}
WANTED = ("element", "stage", "a_ki_per_s", "g_i", "g_k", "e_i_ev", "e_k_ev")


class LinesFault(ValueError):
    """A file of lines that cannot be read; the text says which line of it, and why."""


def read_lines(text: str) -> LineTable:
    """The lines of a CSV file with a heading, ascending in wavelength.

    Rows without a transition probability are left out, as most of NIST's are. Raises LinesFault.
    """
    rows = csv.DictReader(line for line in text.splitlines() if not line.startswith("#"))
    headings = [heading.strip() for heading in rows.fieldnames or ()]
    rows.fieldnames = headings
    missing = [NAMES[key][0] for key in WANTED if not set(NAMES[key]) & set(headings)]
    if not set(NAMES["vacuum_nm"] + NAMES["air_nm"]) & set(headings):
        missing.append("wavelength_vacuum_nm (or wavelength_air_nm)")
    if missing:
        raise LinesFault(f"no column {', '.join(missing)}")
    found = []
    for row in rows:
        try:
            line = _line(row)
        except ValueError as fault:
            raise LinesFault(f"row {rows.line_num}: {fault}") from fault
        if line is not None:
            found.append(line)
    if not found:
        raise LinesFault("no line in it has a transition probability")
    return _table(found)


def _line(row: Mapping[str, str]) -> tuple | None:
    a_ki = _cell(row, "a_ki_per_s")
    if not a_ki:
        return None
    element, stage = _cell(row, "element"), _cell(row, "stage")
    if element not in SYMBOLS:
        raise ValueError(f"{element!r} is not the symbol of an element")
    if stage not in ("1", "2"):
        raise ValueError(f"stage is 1 (I, atoms) or 2 (II, ions), not {stage!r}")
    a, g_i, g_k = (_positive(row, key) for key in ("a_ki_per_s", "g_i", "g_k"))
    low, high = _number(row, "e_i_ev"), _positive(row, "e_k_ev")
    nm = _wavelength_nm(row)
    from_levels = HC_EV_NM / (high - low) if high > low else math.inf
    if abs(from_levels / nm - 1) > UNLIKE:
        raise ValueError(
            f"the levels {low:g} and {high:g} eV make a line at {from_levels:.3f} nm, not {nm:.3f}"
        )
    return element, int(stage), nm, a, g_i, g_k, low, high, _cell(row, "accuracy")


def _wavelength_nm(row: Mapping[str, str]) -> float:
    if _cell(row, "vacuum_nm"):
        return _positive(row, "vacuum_nm")
    return float(to_vacuum(np.array(_positive(row, "air_nm"))))


def _cell(row: Mapping[str, str], key: str) -> str:
    """The first of the columns that holds something; NIST writes ="370.1" and [370.1]."""
    for name in NAMES[key]:
        if cell := (row.get(name) or "").strip().strip('="[]() '):
            return cell
    return ""


def _number(row: Mapping[str, str], key: str) -> float:
    written = _cell(row, key)
    try:
        number = float(written)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError(f"{NAMES[key][0]} is {written!r}, not a number")
    return number


def _positive(row: Mapping[str, str], key: str) -> float:
    number = _number(row, key)
    if number <= 0:
        raise ValueError(f"{NAMES[key][0]} is {number:g}, not above 0")
    return number


def _table(found: list[tuple]) -> LineTable:
    found.sort(key=lambda line: (line[2], line[0]))
    element, stage, *numbers, accuracy = zip(*found, strict=True)
    nm, a, g_i, g_k, low, high = np.array(numbers, dtype=np.float64)
    return LineTable(
        np.array(element, dtype="U2"),
        np.array(stage, dtype=np.int8),
        nm, a, g_i, g_k, low, high,
        np.array(accuracy, dtype="U3"),
        np.full(len(found), np.nan),
        np.full((len(found), 3), np.nan),
    )  # fmt: skip
