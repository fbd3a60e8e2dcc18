"""Read a table with a spectrum in each row, and the wavelengths in its first line or heading."""

import re

import numpy as np

from .axis import counts_channels, may_be_nm
from .dialect import COMMENT, fields_of, is_row, lines_of, numeric, value
from .fault import Unreadable
from .readout import Readout
from .spectrum import FloatArray
from .text_bytes import shown

LEAST = 50  # wavelengths
LONG = 4 * LEAST  # characters of a line that has them
MOST_ABOVE = 3  # long lines before them, as of what each column is
LOOKED_AT = 16_384  # characters, before which the wavelengths must begin
# As programs name columns: 200.1, "X200.1" (R), 200.1 nm, wl_200.1, and 200.1.1 (pandas, the second).
NAMED = re.compile(r"[a-z_]{0,10}\s?(\d+([.,]\d+)?(e[+-]?\d+)?)(\.\d\d?)?\s?(nm)?", re.I)
ASCENDING = 0.98  # of the steps; others are the seams of detectors
PYHAT = {"", "meta", "comp", "wvl"}  # what stands above the headings of its tables
SHOWN = 3


def _all_short(text: bytes) -> bool:
    """Whether no line has LONG characters."""
    at = -1  # of a line's end
    while at + LONG < len(text):
        following = text.rfind(b"\n", at + 1, at + LONG + 1)
        if following < 0:
            return False
        at = following
    return True


def read_rows(text: bytes) -> Readout | None:
    """The spectra; None for another kind of table. Raises Unreadable, with the line."""
    if (marked := _marked(text)) is not None:
        return marked
    stop = text.find(b"\n", LOOKED_AT)
    beginning = text[:stop] if stop > 0 else text
    if _all_short(beginning):
        return None
    n_long = 0
    for at, _, raw in lines_of(text):
        if n_long > MOST_ABOVE or (not n_long and at > len(beginning)):
            return None
        if len(raw) < LONG:
            continue
        n_long += 1
        line = shown(raw).lstrip("#%! ") if raw.startswith(COMMENT) else raw.decode("latin-1")
        separator = max(";\t,", key=line.count)
        if line.count(separator) < LEAST:
            separator = ""
        fields = _cells(line, separator)
        decimal = "," if separator in ("", ";", "\t") and "," in line else "."
        named = [_named(field, decimal) for field in fields]
        begin = next(
            (k for k in range(len(named)) if named[k:] and _all(named[k : k + LEAST])), None
        )
        if begin is None:
            if is_row(fields):
                return None
            continue
        if numeric(fields[begin + LEAST - 1]):
            while not numeric(fields[begin]):
                begin += 1  # SiO2 and TiO2, before plain wavelengths
        end = next((k for k in range(begin, len(named)) if named[k] is None), len(named))
        axis = np.array(named[begin:end], dtype=np.float64)
        if not _may_be_wavelengths(axis):
            continue  # numbers of the columns, above the wavelengths
        if sum(one is not None for one in named[end:]) >= LEAST:
            raise _interrupted(fields, end)
        return _read(text, at + len(raw) + 1, fields, (begin, end), axis, separator, decimal)
    return None


def _marked(text: bytes) -> Readout | None:
    """The spectra of a table of PyHAT's, which says where the wavelengths are, however few."""
    first = text[: text.find(b"\n")] if b"\n" in text else text
    kinds = [kind.strip().casefold() for kind in _cells(first.decode("latin-1"), ",")]
    if "wvl" not in kinds or not PYHAT.issuperset(kinds):
        return None
    second, _, rows = text[len(first) + 1 :].partition(b"\n")
    fields = _cells(second.decode("latin-1"), ",")
    begin, n = kinds.index("wvl"), kinds.count("wvl")
    named = [_named(field, ".") for field in fields[begin : begin + n]]
    if "wvl" in kinds[begin + n :]:
        raise _interrupted(fields, next(k for k in range(begin, len(kinds)) if kinds[k] != "wvl"))
    if len(named) < n or None in named:
        return None
    axis = np.array(named, dtype=np.float64)
    return _read(text, len(text) - len(rows), fields, (begin, begin + n), axis, ",", ".")


def _interrupted(fields: list[str], at: int) -> Unreadable:
    return Unreadable(
        f"the wavelengths above the spectra are interrupted by {fields[at].strip()[:20]!r}, "
        f"column {at + 1}; put such columns before or after them"
    )


def _may_be_wavelengths(axis: FloatArray) -> bool:
    """Whether these are an axis, of several detectors perhaps, and in any unit."""
    ascending = axis if axis[-1] > axis[0] else axis[::-1]
    if may_be_nm(ascending):
        return True
    few_back = np.mean(np.diff(ascending) > 0) > ASCENDING and not counts_channels(ascending)
    return bool(few_back and ascending.min() > 0)


def _cells(line: str, separator: str) -> list[str]:
    """The cells of a row, empty ones too."""
    if not separator or '"' in line:
        return fields_of(line, separator)
    return line.strip("\r\n").split(separator)


def _names(leading: list[list[str]]) -> str:
    """The names of the rows, from the first column where each has its own; none for numbers."""
    for names in zip(*leading, strict=False):
        if len(set(names)) == len(names) > 1 and not any(map(numeric, names)):
            return f": {', '.join(names[:SHOWN])}" + (" ..." if len(names) > SHOWN else "")
    return ""


def _down(cells: list[str]) -> bool:
    """Whether the first cells of the rows are wavelengths."""
    named = [_named(cell, ".") for cell in cells]
    down = np.array([one for one in named if one is not None])
    return len(down) == len(cells) > 3 and (may_be_nm(down) or may_be_nm(down[::-1]))


def _all(named: list[float | None]) -> bool:
    return len(named) == LEAST and None not in named


def _named(field: str, decimal: str) -> float | None:
    found = NAMED.fullmatch(field.strip().strip('"').strip())
    try:
        return None if found is None else value(found[1], decimal)
    except ValueError:
        return None


def _read(text, at, fields, ends, axis, separator, decimal) -> Readout | None:
    begin, end = ends
    rows: list[list[float]] = []
    leading: list[list[str]] = []
    before = text.count(b"\n", 0, at) + 1
    for _, number, raw in lines_of(text, at, before):
        if not raw.strip() or raw.startswith(COMMENT):
            continue
        line = raw.decode("latin-1")
        cells = _cells(line, separator)
        if len(cells) > len(fields) and not cells[-1].strip():
            cells.pop()
        more = len(cells) - len(fields)  # one, where the names of the rows have no heading
        if more not in (0, 1) or (more == 1 and begin):
            if not rows:
                return None
            raise Unreadable(
                f"line {number} has {len(cells)} columns, and the line of wavelengths has "
                f"{len(fields)}; was the file cut off while it was written?"
            )
        leading.append(cells[: max(begin, 1)])
        try:
            rows.append(
                [
                    value(c.strip().strip('"').strip(), decimal)
                    for c in cells[begin + more : end + more]
                ]
            )
        except ValueError:
            if not rows:
                return None
            raise Unreadable(f"line {number} has words where counts should be") from None
    if not rows or (counts_channels(axis) and _down([cells[0] for cells in leading])):
        return None  # numbers of shots over their columns
    aside = [k for k in range(len(fields)) if not begin <= k < end]
    notes = [f"the spectra are the rows of the table{_names(leading)}"]
    if aside:
        called = [
            f"column {k + 1}" + (f" ({fields[k].strip()})" if fields[k].strip() else "")
            for k in aside
        ]
        notes.append(
            f"not used: {', '.join(called[:SHOWN])}" + (" ..." if len(called) > SHOWN else "")
        )
    return Readout(
        axis, np.array(rows), None, tuple(notes), not all(map(numeric, fields[begin:end]))
    )
