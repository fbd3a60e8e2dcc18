"""Find where the numbers of a text begin, and how they are written.

Instruments put blocks of words before (and after) the numbers, separate columns by commas,
semicolons, tabs or spaces, and write decimals with a point or a comma.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass

from .fault import Unreadable
from .text_bytes import shown

COMMENT = (b"#", b"%", b"//", b"!", b"*", b";;", b">>>>>")
BAD_CHANNEL = (
    "", "nan", "-nan", "na", "n/a", "null", "none", "inf", "-inf", "+inf", "-", "--", "---", "*", "***",
    "#n/a", "#nv", "#value!", "#num!", "1.#qnan", "-1.#ind", "1.#ind", "1.#inf", "-1.#inf",
    "over", "overflow", "ovld", "sat", "saturated",
)  # fmt: skip
NUMBER = re.compile(r"[+-]?(\d[\d.,]*|[.,]\d+|\d{1,3}([ ']\d{3})+([.,]\d*)?)([eEdD][+-]?\d+)?")
THOUSANDS_APART = re.compile(r"(?<=\d)[ '](?=\d{3})")
UNIT_WORD = re.compile(
    r"[\[(]?\s*(nm|å|a|ang\w*|[µμup]m|counts?|a\.?\s?u\.?|arb\.?.*|dn|%|cts|nanomet\w*)\s*[\])]?"
    r"|\[[^\[\]]+\]|\([^()]+\)",
    re.I,
)
THOUSANDS = re.compile(r"[+-]?\d{1,3}(,\d{3})+(\.\d*)?([eEdD][+-]?\d+)?")
THOUSANDS_BY_POINTS = re.compile(r"[+-]?\d{1,3}(\.\d{3})+(,\d*)?([eEdD][+-]?\d+)?")
WORDS = re.compile(r"\s{2,}|[\t;,]")
CONFIRMING = 2  # lines of the same kind after the first one of the numbers
MOST_WORDS = 4  # lines before the numbers that may be headings
SAMPLED, LINE = 200, 100  # lines that the decimal mark is told from; bytes of a long one
SPACES = ""


@dataclass(frozen=True, slots=True)
class Dialect:
    """begin: offset of the first line of numbers, from 0; line: its number, from 1.

    words: numbers do not stand in the first column.

    separator: one character, SPACES for runs of blanks. decimal: the mark. columns: of the first
    line. headings: of the columns, empty if there are none; above: the lines before the numbers.
    """

    begin: int
    line: int
    separator: str
    decimal: str
    columns: int
    headings: tuple[str, ...]
    above: tuple[str, ...]
    words: bool = False


def fields_of(line: str, separator: str) -> list[str]:
    """The fields of a line; quotes around them are taken off."""
    line = line.strip()
    if separator == SPACES:
        return line.split() or [""]
    fields = _csv(line, separator) if '"' in line else line.split(separator)
    return [field.strip() for field in fields]


def separator_of(line: str) -> str:
    """The character between the columns of a line of numbers."""
    bare = re.sub(r'"[^"]*"', '""', line) if '"' in line else line
    for separator in ";\t|":
        if separator in bare.strip():
            return separator
    if "," not in bare:
        return SPACES
    words = bare.split()
    decimals = len(words) > 1 and all(NUMBER.fullmatch(w) and w[-1] != "," for w in words)
    return SPACES if decimals and any("," in word for word in words) else ","


def numeric(field: str) -> bool:
    return bool(NUMBER.fullmatch(field))


def is_row(fields: list[str]) -> bool:
    """Whether a line holds numbers: two at least, or one and a channel without a count."""
    if not fields:
        return False
    numbers = sum(map(numeric, fields))
    empty = sum(field.lower() in BAD_CHANNEL for field in fields)
    first = numeric(fields[0]) or fields[0].lower() in BAD_CHANNEL[1:]
    return first and numbers >= 1 and numbers + empty >= 2


def find(text: bytes, words: bool = False) -> Dialect | None:
    """The dialect of a text; None without a line of numbers. words: may stand before them."""
    above: list[str] = []
    first: tuple[int, int, str, list[str], int] | None = None  # the last: lines above it
    lone, confirmed = first, 0
    for at, number, raw in lines_of(text):
        if not raw.strip():
            continue
        line = shown(raw)
        if raw.strip().startswith(COMMENT):
            above.append(line)
            continue
        separator = separator_of(line)
        fields = fields_of(line, separator)
        if len(fields) > 2 and not fields[-1]:
            fields.pop()  # "200;5;" has two columns
        row = is_row(fields[1:] if words and len(fields) > 2 else fields)
        if row and first and (separator, len(fields)) == (first[2], len(first[3])):
            confirmed += 1
            if confirmed == CONFIRMING:
                break
            continue
        if row:
            first, confirmed = (at, number, separator, fields, len(above)), 0
            lone = lone or first
        else:
            first = None
        above.append(line)
    if words and confirmed < CONFIRMING:
        return None
    if first is None or confirmed == 0:
        first = lone
    if first is None:
        return None
    at, number, separator, fields, n_above = first
    told = tuple(above[:n_above])
    return Dialect(
        at, number, separator, _decimal(text, at, separator, words), len(fields),
        headings(told, separator, len(fields)), told, words,
    )  # fmt: skip


def lines_of(text: bytes, at: int = 0, number: int = 1) -> Iterator[tuple[int, int, bytes]]:
    """Offset, number and bytes of every line."""
    while at < len(text):
        stop = text.find(b"\n", at)
        stop = len(text) if stop < 0 else stop
        yield at, number, text[at:stop]
        at, number = stop + 1, number + 1


def headings(above: tuple[str, ...], separator: str, columns: int) -> tuple[str, ...]:
    """The names of the columns, each with its unit if a line of units follows."""
    units: list[str] = []
    for line in reversed(above[-MOST_WORDS:]):
        line = line.strip().lstrip("#%!*/").strip()
        if line.startswith(">>>>>") or not line:
            continue
        cells = fields_of(line, separator)
        if len(cells) == columns > 2 and not numeric(cells[0]) and all(map(numeric, cells[1:])):
            continue  # of each shot: its exposure, say
        names = _names(line, separator, columns)
        if names is None or names[0].endswith(("=", ":")):
            return ()  # of the instrument, not of the columns
        if not units and all(UNIT_WORD.fullmatch(name) for name in names if name):
            units = names
            continue
        return tuple(
            f"{n} {u}".strip() for n, u in zip(names, units or [""] * columns, strict=True)
        )
    return tuple(units)


def _names(line: str, separator: str, columns: int) -> list[str] | None:
    ways = [fields_of(line, separator)]
    if separator == SPACES or separator not in line:
        ways += [WORDS.split(line), line.split()]
    for fields in ways:
        fields = [field.strip().strip('"') for field in fields]
        if len(fields) == columns - 1 and columns > 2:
            fields.append("")  # the last column often has no unit
        elif len(fields) == columns + 1 and columns > 2:
            fields.pop()  # of a result that was not exported
        if len(fields) == columns and not any(numeric(field) for field in fields):
            return fields
    return None


def value(field: str, decimal: str) -> float:
    """A field's number; a channel without one is NaN. Raises ValueError for words."""
    if field.lower() in BAD_CHANNEL:
        return math.nan
    if "_" in field:
        raise ValueError(field)
    if (" " in field or "'" in field) and NUMBER.fullmatch(field):
        field = THOUSANDS_APART.sub("", field)
    field = field.replace("D", "e").replace("d", "e")
    if "," not in field and (decimal == "." or "." not in field):
        return float(field)
    other = "." if decimal == "," else ","
    if other in field:
        if not (THOUSANDS if other == "," else THOUSANDS_BY_POINTS).fullmatch(field):
            raise ValueError(field)
        field = field.replace(other, "")
    return float(field.replace(decimal, "."))


def _decimal(text: bytes, at: int, separator: str, words: bool) -> str:
    """The decimal mark. Raises Unreadable where commas may be decimals or thousands alike."""
    end = text.find(b"\n", at + SAMPLED * LINE)  # of the last line, which may be long
    sampled = text[at : len(text) if end < 0 else end]
    if (b'"' if separator == "," else b",") not in sampled:
        return "."
    lines = sampled.split(b"\n")[:SAMPLED]
    within = [raw for raw in lines if b"," in raw and (separator != "," or b'"' in raw)]
    if not within:
        return "."
    sample = [fields_of(shown(raw), separator)[words:] for raw in lines if raw.strip()]
    sample = [fields for fields in sample if is_row(fields)]
    numbers = [f for fields in sample for f in fields if numeric(f)]
    commas = [f for f in numbers if "," in f and "." not in f]
    if not commas:
        return "," if any(THOUSANDS_BY_POINTS.fullmatch(f) and "," in f for f in numbers) else "."
    in_axis = any("," in fields[0] for fields in sample)
    points = [f for f in numbers if "." in f and "," not in f]
    if points:
        # 190,0941;16.372: counts of some thousands beside wavelengths with decimal commas
        decimals = in_axis and not all(THOUSANDS.fullmatch(f) for f in commas)
        return "," if decimals and all(map(THOUSANDS_BY_POINTS.fullmatch, points)) else "."
    if not in_axis and all(THOUSANDS.fullmatch(f) and f[0] != "0" for f in commas):
        raise Unreadable(
            f"{commas[0]!r} may be {commas[0].replace(',', '.')} or {commas[0].replace(',', '')}; "
            "export the numbers with decimal points"
        )
    return ","


def _csv(line: str, separator: str) -> list[str]:
    import csv

    try:
        return next(csv.reader([line], delimiter=separator))
    except csv.Error:  # a field of more than 131,072 characters: no number
        return line.split(separator)
