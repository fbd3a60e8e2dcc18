"""Lines from a CSV file, beside those of the shipped table: of one's own, or as NIST exports them.

A fault in one's own file is refused by its row. Of an export, which nobody wrote by hand, what can be
read is read, and a note counts each kind of what is doubtful or left out.
"""

import csv
import math
import re
from collections import Counter
from collections.abc import Mapping

import numpy as np

from .air import to_vacuum
from .symbols import SYMBOLS
from .table import LineTable

HC_EV_NM = 1239.8419843  # h c (CODATA 2018, exact)
UNLIKE = 0.002  # share by which wavelength and levels may differ, rounding included
TABLES_AIR_NM = 200.0  # below, tables print vacuum wavelengths under "air"
EV = {"eV": 1.0, "cm-1": HC_EV_NM * 1e-7, "Ry": 13.605693123}
NM = {"nm": 1.0, "A": 0.1, "um": 1000.0}

# What each column may be called: labrun's name first, then those of an export from NIST's ASD.
NAMES = {
    "element": ("element",),
    "stage": ("stage", "sp_num"),
    "vacuum_nm": ("wavelength_vacuum_nm", "ritz_wl_vac", "obs_wl_vac"),
    "air_nm": ("wavelength_air_nm", "ritz_wl_air", "obs_wl_air"),
    "a_ki_per_s": ("a_ki_per_s", "Aki(s^-1)", "gA(s^-1)"),
    "g_i": ("g_i", "J_i"),
    "g_k": ("g_k", "J_k"),
    "e_i_ev": ("e_i_ev", "Ei"),
    "e_k_ev": ("e_k_ev", "Ek"),
    "accuracy": ("accuracy", "Acc"),
}
WANTED = ("element", "stage", "a_ki_per_s", "g_i", "g_k", "e_i_ev", "e_k_ev")
UNITS = re.compile(r"^(?P<name>(?:ritz|obs)_wl_(?:vac|air)|E[ik])\((?P<unit>nm|A|um|eV|cm-1|Ry)\)$")
BRACKETS = "[]() "
OFFSET = re.compile(r"\+\s*[a-z]$")  # of levels whose distance from the others nobody knows
MARKS = {
    "?": "a level that NIST marks ?: it may not be real",
    "†": "a level that NIST marks †: its energy is not that of the observed line, or its name is doubtful",
    "+x": "levels that are known up to a common shift (+x): their populations are uncertain",
}
NO_A = "no transition probability"


class LinesFault(ValueError):
    """A file of lines that cannot be read; the text says which line of it, and why."""


class _LeftOut(ValueError):
    """A row of an export that cannot be used; the text is the kind."""


def read_lines(text: str, notes: list[str] | None = None) -> LineTable:
    """The lines of a CSV file with a heading, ascending in wavelength.

    Rows without a transition probability are left out, as most of NIST's are. notes: gets a
    sentence for each kind of row that is doubtful, or left out. Raises LinesFault.
    """
    kept = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    rows = csv.DictReader(kept, delimiter="\t" if kept and "\t" in kept[0] else ",")
    headings = [heading.strip() for heading in rows.fieldnames or ()]
    units = {m["name"]: m["unit"] for m in map(UNITS.match, headings) if m}
    headings = [m["name"] if (m := UNITS.match(heading)) else heading for heading in headings]
    rows.fieldnames = headings
    missing = [NAMES[key][0] for key in WANTED if not set(NAMES[key]) & set(headings)]
    if not set(NAMES["vacuum_nm"] + NAMES["air_nm"]) & set(headings):
        missing.append("wavelength_vacuum_nm (or wavelength_air_nm)")
    if missing:
        raise LinesFault(f"no column {', '.join(missing)}")
    exported = "a_ki_per_s" not in headings
    found, doubtful, left_out = [], Counter[str](), Counter[str]()
    for row in rows:
        try:
            line, marks = _line(row, units, exported)
        except _LeftOut as kind:
            left_out[str(kind)] += 1
        except ValueError as fault:
            raise LinesFault(f"row {rows.line_num}: {fault}") from fault
        else:
            found.append(line)
            doubtful.update(marks)
    if not found:
        raise LinesFault(
            "no line in it has a transition probability"
            if set(left_out) <= {NO_A}
            else f"no line in it can be used: {_counted(left_out)}"
        )
    if notes is not None:
        notes += [f"{n:,} of {len(found):,} lines have {MARKS[mark]}"
                  for mark, n in doubtful.items()]  # fmt: skip
        if left_out:
            notes.append(f"rows left out: {_counted(left_out)}")
    return _table(found)


def _counted(left_out: Counter[str]) -> str:
    return ", ".join(f"{n:,} ({kind})" for kind, n in left_out.most_common())


def _line(row: Mapping[str, str], units: Mapping[str, str], exported: bool) -> tuple[tuple, set]:
    """A line, and what is doubtful of it. Raises _LeftOut for a row of an export; ValueError."""
    if not _cell(row, "a_ki_per_s"):
        raise _LeftOut(NO_A)
    element, stage = _cell(row, "element"), _cell(row, "stage")
    marks: set[str] = set()
    if exported:
        _check_usable(row, element, stage)
    if element not in SYMBOLS:
        raise ValueError(f"{element!r} is not the symbol of an element")
    if stage not in ("1", "2"):
        raise ValueError(f"stage is 1 (I, atoms) or 2 (II, ions), not {stage!r}")
    try:
        a, g_i, g_k = _positive(row, "a_ki_per_s"), _weight(row, "g_i"), _weight(row, "g_k")
        low = _level(row, "e_i_ev", units.get("Ei"), marks)
        high = _level(row, "e_k_ev", units.get("Ek"), marks)
    except ValueError as fault:
        raise (_LeftOut(str(fault)) if exported else fault) from fault
    if high <= 0:
        raise ValueError(f"e_k_ev is {high:g}, not above 0")
    if exported and not _bare(row.get("Aki(s^-1)")):
        a /= g_k  # the column is gA
    from_levels = HC_EV_NM / (high - low) if high > low else math.inf
    nm = _wavelength_nm(row, units, from_levels)
    if abs(from_levels / nm - 1) > UNLIKE:
        if exported:
            raise _LeftOut("a wavelength that is not that of the levels")
        raise ValueError(
            f"the levels {low:g} and {high:g} eV make a line at {from_levels:.3f} nm, not {nm:.3f}"
        )
    return (element, int(stage), nm, a, g_i, g_k, low, high, _cell(row, "accuracy")), marks


def _check_usable(row: Mapping[str, str], element: str, stage: str) -> None:
    """Raise _LeftOut for a row of an export that lacks what a line needs."""
    if element in ("D", "T") or element[:1].isdigit():
        raise _LeftOut("isotopes")
    if stage.isdecimal() and int(stage) > 2:
        raise _LeftOut("stage III or higher")
    if not (_cell(row, "e_i_ev") and _cell(row, "e_k_ev")):
        raise _LeftOut("no levels")
    if not (_cell(row, "g_i") and _cell(row, "g_k")):
        raise _LeftOut("no statistical weights")


def _level(row: Mapping[str, str], key: str, unit: str | None, marks: set[str]) -> float:
    """An energy in eV. In an export a mark may follow it, which is added to `marks`."""
    written = _cell(row, key)
    if unit is None:
        return _number(written, key)
    bare = written.replace("&dagger;", "†")
    for mark in "?†":
        if mark in bare:
            marks.add(mark)
            bare = bare.replace(mark, "")
    bare = bare.strip(BRACKETS)
    if OFFSET.search(bare):
        marks.add("+x")
        bare = OFFSET.sub("", bare).strip(BRACKETS)
    return _number(bare, key) * EV[unit]


def _weight(row: Mapping[str, str], key: str) -> float:
    """2J + 1, which an export may give as J, such as 3/2."""
    if row.get(key) or not (j := _cell(row, key)):
        return _positive(row, key)
    twice, _, halves = j.partition("/")
    if not twice.isdecimal() or halves not in ("", "2"):
        raise ValueError(f"J is {j!r}, not a number such as 3/2")
    return float(int(twice) * (1 if halves else 2) + 1)


def _wavelength_nm(row: Mapping[str, str], units: Mapping[str, str], from_levels: float) -> float:
    """In vacuum. What a table calls air is vacuum below 200 nm, if the levels say so."""
    for key in ("vacuum_nm", "air_nm"):
        for name in NAMES[key]:
            if written := _bare(row.get(name)):
                nm = _above_0(_number(written, key), key) * NM[units.get(name, "nm")]
                if key == "vacuum_nm":
                    return nm
                in_air = float(to_vacuum(np.array(nm)))
                both = (nm, in_air) if nm < TABLES_AIR_NM else (in_air,)
                return min(both, key=lambda one: abs(one - from_levels))
    raise ValueError("wavelength_vacuum_nm is '', not a number")


def _cell(row: Mapping[str, str], key: str) -> str:
    """The first of the columns that holds something."""
    return next((cell for name in NAMES[key] if (cell := _bare(row.get(name)))), "")


def _bare(cell: str | None) -> str:
    """NIST writes ="370.1", [370.1] for what was interpolated, (370.1) for what is from theory."""
    return (cell or "").strip().strip('="' + BRACKETS)


def _number(written: str, key: str) -> float:
    try:
        number = float(written)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError(f"{NAMES[key][0]} is {written!r}, not a number")
    return number


def _above_0(number: float, key: str) -> float:
    if number <= 0:
        raise ValueError(f"{NAMES[key][0]} is {number:g}, not above 0")
    return number


def _positive(row: Mapping[str, str], key: str) -> float:
    return _above_0(_number(_cell(row, key), key), key)


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
