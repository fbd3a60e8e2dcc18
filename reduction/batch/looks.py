"""Decide whether a file in a folder may be a spectrum, by its name and its first lines.

If in doubt it is one: a damaged spectrum must be reported, and only a file that is clearly
something else may be skipped.
"""

import re
from pathlib import Path

TEXT = {".csv", ".tsv", ".txt", ".dat", ".asc", ".xy", ".prn"}
SUFFIXES = {*TEXT, ".npy"}
BEGINNING = 8192  # bytes that are examined
AXIS = re.compile(r"wave|lambda|λ|wl\b|nm\b|ang|å|pixel|channel|x\b", re.I)
BETWEEN = re.compile(r"[,;\t]|\s+")
SHOWN = 40


def not_a_spectrum(path: Path) -> str | None:
    """Why a file of a folder is skipped, or None. Raises OSError if it cannot be opened."""
    if path.name.startswith("."):
        return "hidden"
    if path.exists() and not path.is_file():
        return "not a regular file: a pipe, a socket or a device"
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        return f"a spectrum has one of the suffixes {' '.join(sorted(SUFFIXES))}"
    if suffix not in TEXT:
        return None
    with path.open("rb") as file:
        beginning = file.read(BEGINNING)
    return _other_text(beginning, suffix)


def _other_text(beginning: bytes, suffix: str) -> str | None:
    try:
        lines = beginning.decode("utf-8-sig", "strict" if len(beginning) < BEGINNING else "ignore")
    except UnicodeDecodeError:
        return None  # a damaged spectrum
    told = [line.strip() for line in lines.splitlines()]
    told = [line for line in told if line and not line.startswith("#")]
    if not told or _numbers(told[0]):
        return None
    if AXIS.match(told[0].lstrip("\"' ")) or any(_two_numbers(line) for line in told[1:2]):
        return None
    if suffix == ".txt" and any(_two_numbers(line) for line in told):
        return None
    return f"its first line is not a spectrum's header: {told[0][:SHOWN]!r}"


def _numbers(line: str) -> bool:
    """Whether a line begins with a number, as the lines of a spectrum do."""
    return _is_number(BETWEEN.split(line, maxsplit=1)[0])


def _two_numbers(line: str) -> bool:
    fields = [field for field in BETWEEN.split(line) if field]
    return len(fields) == 2 and all(_is_number(field) for field in fields)


def _is_number(field: str) -> bool:
    try:
        float(field)
    except ValueError:
        return False
    return True
