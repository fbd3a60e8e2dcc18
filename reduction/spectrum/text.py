"""Read a spectrum from the text that an analyser or a spectrometer's program exports.

Two columns of plain numbers, by far the most frequent, go through a compiled loop; everything else
through Python, line by line.
"""

import math
import re

import numpy as np

from .axis import WAVELENGTH, Unit, unit_named
from .columns import AXIS, check_above, choose, side_by_side
from .dialect import COMMENT, Dialect, fields_of, find, lines_of, numeric, value
from .fault import Unreadable
from .readout import Readout
from .rows_of_shots import read_rows
from .spectrum import FloatArray
from .text_bytes import shown, text_bytes

SHORTEST = 4  # bytes of a line of two numbers, its end among them
SHOWN = 40  # characters of a faulty line shown in an error
WHOLE = re.compile(r"[+-]?\d+")
LABSPEC = re.compile(r"#Spectro\s*\(cm", re.I)
ALIKE = 50  # lines with equal decimals: no program that drops zeros writes so many
LAST_DECIMALS, LAST_DECIMALS_OR_COMMA = re.compile(rb"\.(\d+)\s*$"), re.compile(rb"[.,](\d+)\s*$")
CUT = "; was the file cut off while it was written?"


def read_text(raw: bytes, columns: tuple[str, ...] | None = None) -> Readout:
    """The axis and the shots. columns: numbers from 1 or headings, wavelengths first."""
    text = text_bytes(raw)
    if not text or text.isspace():
        raise Unreadable("the spectrum is empty: it has no row of wavelength and intensity")
    if columns is None and (rows := read_rows(text)) is not None:
        return rows
    dialect = find(text) or find(text, words=True)
    if dialect is None:
        raise _no_numbers(text)
    _check_end(text, dialect)
    notes: list[str] = []
    commas = dialect.columns == 2 and dialect.decimal == "," != dialect.separator
    if commas and text.find(b".", dialect.begin) < 0:
        body = text[dialect.begin :].replace(b",", b".")
        table = _pairs(text[: dialect.begin] + body, dialect, ".")
    elif dialect.columns == 2:
        table = _pairs(text, dialect, dialect.decimal)
    else:
        table, by_commas = _wide(text, dialect)
        if by_commas:
            notes.append("the decimals are commas, and so are the marks between the columns")
            dialect = Dialect(dialect.begin, dialect.line, ",", ",", 2,
                              dialect.headings if len(dialect.headings) == 2 else (),
                              dialect.above)  # fmt: skip
    if dialect.decimal == ",":
        notes.append("decimal commas")
    headings = dialect.headings
    if columns is None:
        headings, table, more = side_by_side(headings, table)
        notes += more
    chosen = choose(headings, table, columns)
    if columns is None:
        check_above(dialect.above)
    unit = chosen.unit or _unit_above(dialect)
    name = headings[chosen.axis] if headings else ""
    said = any(WAVELENGTH.search(line) for line in (name, *dialect.above))
    return Readout(
        table[chosen.axis], table[list(chosen.shots)], unit, (*notes, *chosen.notes), said
    )


def _unit_above(dialect: Dialect) -> Unit | None:
    """The unit in a heading that cannot be split into columns, or in LabSpec's place of its grating."""
    if any(LABSPEC.match(line) for line in dialect.above):
        return "cm-1"
    if dialect.headings or not dialect.above or not AXIS.search(dialect.above[-1]):
        return None
    return unit_named(dialect.above[-1])


def _pairs(text: bytes, dialect: Dialect, decimal: str) -> FloatArray:
    """Two columns, shape (2, n)."""
    from .parse import pairs, plain_pairs  # compiled: kept out of the import of this file

    array = np.frombuffer(text, dtype=np.uint8)
    n_most = (len(array) - dialect.begin) // SHORTEST + 1
    table = np.empty((2, n_most))
    at, n = dialect.begin, 0
    while True:
        at, n = plain_pairs(array, at, table[0], table[1], n)
        at, n = pairs(array, at, table[0], table[1], n)
        if at >= len(text):
            break
        stop = text.find(b"\n", at)
        stop = len(text) if stop < 0 else stop
        row = _odd_line(text, at, stop, dialect, decimal)
        if row is _END:
            break
        if row is not None:
            table[:, n] = row
            n += 1
        at = stop + 1
    return table[:, :n]


_END: list[float] = []
WORD = -math.inf  # in a column of words beside the numbers; no count is read as infinite


def _odd_line(
    text: bytes, at: int, stop: int, dialect: Dialect, decimal: str
) -> list[float] | None:
    """The numbers of a line that is not two plain numbers; None to skip it, _END at a footer."""
    raw = text[at:stop]
    if not raw.strip() or raw.strip().startswith(COMMENT):
        return None
    line = shown(raw)
    fields = fields_of(line, dialect.separator)
    if len(fields) == dialect.columns + 1 and not fields[-1]:
        fields.pop()
    as_ever = len(fields) == dialect.columns and dialect.words
    if not numeric(fields[0]) and fields[0].lower() not in ("nan", "") and not as_ever:
        if _footer(text, stop):
            return _END
        if _starts_over(text, stop, dialect):
            return None
    if not line.isprintable() and "\t" not in line:
        raise Unreadable(f"{_where(text, at)} is not text; is this file damaged?")
    last = CUT if stop >= len(text.rstrip()) else ""
    if len(fields) < 2:
        raise Unreadable(
            f"{_where(text, at)} has one column ({line[:SHOWN]!r}); "
            f"a spectrum has two, wavelength and intensity{last}"
        )
    if len(fields) != dialect.columns:
        raise Unreadable(
            f"{_where(text, at)} has {len(fields)} columns ({line[:SHOWN]!r}), and line {dialect.line} "
            f"has {dialect.columns}{last}"
        )
    numbers = []
    for place, field in enumerate(fields):
        try:
            numbers.append(value(field, decimal))
        except ValueError:
            if place > 1 or dialect.words:
                numbers.append(WORD)
                continue
            what = "two numbers" if dialect.columns == 2 else "numbers"
            raise Unreadable(f"{_where(text, at)} is not {what}: {line[:SHOWN]!r}") from None
    if not (math.isfinite(numbers[0]) or dialect.words):
        raise Unreadable(f"{_where(text, at)} has no wavelength: {line[:SHOWN]!r}")
    return [n if math.isfinite(n) or n is WORD else math.nan for n in numbers]


def _where(text: bytes, at: int) -> str:
    number = text.count(b"\n", 0, at) + 1
    return f"line {number}"


def _footer(text: bytes, at: int) -> bool:
    """Whether no line of numbers follows."""
    for _, _, raw in lines_of(text, at + 1):
        if raw.strip() and not raw.strip().startswith(COMMENT):
            line = shown(raw)
            if numeric(line.split()[0].strip(",;")) and ":" not in line:
                return False
    return True


def _starts_over(text: bytes, at: int, dialect: Dialect) -> bool:
    """Whether the next line of numbers has the wavelength of the first: another spectrum begins."""
    first = fields_of(shown(text[dialect.begin :].split(b"\n", 1)[0]), dialect.separator)[0]
    for _, _, raw in lines_of(text, at + 1):
        fields = fields_of(shown(raw), dialect.separator) if raw.strip() else [""]
        if numeric(fields[0]):
            return fields[0] == first
    return False


def _wide(text: bytes, dialect: Dialect) -> tuple[FloatArray, bool]:
    """More columns, shape (columns, n); and whether commas were decimals too."""
    rows: list[list[float]] = []
    commas = dialect.separator == "," and dialect.columns in (3, 4)
    fields: list[list[str]] = []
    for at, _, raw in lines_of(text, dialect.begin):
        row = _odd_line(text, at, at + len(raw), dialect, dialect.decimal)
        if row is _END:
            break
        if row is not None:
            rows.append(row)
            if commas:
                fields.append(fields_of(shown(raw), ",")[: dialect.columns])
    if not rows:
        raise _no_numbers(text)
    table = np.ascontiguousarray(np.array(rows).T)
    table[np.any(table == WORD, axis=1)] = math.nan
    if commas and len(rows) > 2:
        joined = _joined(fields, table)
        if joined is not None:
            return joined, True
    return table, False


def _joined(fields: list[list[str]], table: FloatArray) -> FloatArray | None:
    """Wavelength and counts of lines such as 200,0338,123,4; None where these are columns."""
    if not all(WHOLE.fullmatch(one) for row in fields for one in row):
        return None
    steps = np.diff(table[0])
    leading = any(len(row[1]) > 1 and row[1][0] == "0" for row in fields)
    if not leading and (np.all(steps > 0) or np.all(steps < 0)):
        return None  # whole wavelengths
    axis = np.array([float(f"{row[0]}.{row[1]}") for row in fields])
    steps = np.diff(axis)
    if not (np.all(steps > 0) or np.all(steps < 0)):
        return None
    return np.stack([axis, np.array([float(".".join(row[2:])) for row in fields])])


def _check_end(text: bytes, dialect: Dialect) -> None:
    """Raise Unreadable where the text ends within its last number.

    That is certain where many lines before all have as many decimals, and the last one, which no
    line feed ends, has fewer.
    """
    if text.endswith(b"\n"):
        return
    *before, last = text[dialect.begin :].rsplit(b"\n", ALIKE + 1)
    if not last or len(before) <= ALIKE:
        return
    ending = LAST_DECIMALS if dialect.separator == "," else LAST_DECIMALS_OR_COMMA
    found = [ending.search(line) for line in (*before[1:], last)]
    *lengths, end = [len(one[1]) if one else 0 for one in found]
    if end < lengths[0] and set(lengths) == {lengths[0]}:
        raise Unreadable(f"the last line ends within a number ({shown(last)[-SHOWN:]!r}){CUT}")


def _no_numbers(text: bytes) -> Unreadable:
    """Why a text has no line of numbers."""
    lines = [(number, shown(raw)) for _, number, raw in lines_of(text) if raw.strip()]
    for number, line in lines:
        if line[:1].isdigit() or line[:1] in "+-.":
            if len(line.replace(",", " ").replace(";", " ").split()) < 2:
                return Unreadable(
                    f"line {number} has one column ({line[:SHOWN]!r}); "
                    "a spectrum has two, wavelength and intensity"
                )
            return Unreadable(f"line {number} is not two numbers: {line[:SHOWN]!r}")
    if AXIS.search(lines[-1][1]) and lines[0][1][0] not in "{[<":
        return Unreadable("the spectrum is empty: it has no row of wavelength and intensity")
    return Unreadable(
        f"no line of it is two numbers; the first is {lines[0][1][:SHOWN]!r}: is it a spectrum?"
    )
