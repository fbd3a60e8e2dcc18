"""Decide whether a file in a folder may be a spectrum, by its name and its first lines.

If in doubt it is one: a damaged spectrum must be reported, and only a file that is clearly
something else may be skipped.
"""

import re
from pathlib import Path

from ..spectrum.columns import AXIS, COUNTER
from ..spectrum.dialect import find, lines_of
from ..spectrum.fault import Unreadable
from ..spectrum.source import beginning_of
from ..spectrum.text_bytes import shown, text_bytes

TEXT = {".csv", ".tsv", ".txt", ".dat", ".asc", ".xy", ".prn", ".ttt", ".trt", ".ssm", ".jaz"}
OTHER = {
    ".npy", ".spc", ".sif", ".h5", ".hdf5", ".nxs", ".jdx", ".dx",
    ".raw8", ".raw8x", ".rwd8", ".irr8", ".rfl8", ".rfl8x", ".str8", ".roh", ".trm",
    ".spe", ".procspec",
}  # fmt: skip
SUFFIXES = {*TEXT, *OTHER}
PACKED = ".gz"
MAY_BE_ANY = "may be any table, and is read only if you name it"
UNREAD = {
    ".wdf": "a Renishaw file; export it as text",
    ".fits": "a FITS file; save its table as CSV",
    ".zip": "an archive; unpack it",
    **dict.fromkeys((".xlsx", ".xls", ".xlsb", ".ods"), f"a spreadsheet {MAY_BE_ANY}"),
    **dict.fromkeys((".mat", ".npz", ".parquet", ".feather"), f"a file of this kind {MAY_BE_ANY}"),
}
BEGINNING = 8192  # bytes that are examined
HEADING = re.compile(r"wave|lambda|λ|wl\b|nm\b|ang|å|pixel|channel|x\b", re.I)
SHOWN = 40


def not_a_spectrum(path: Path) -> str | None:
    """Why a file of a folder is skipped, or None. Raises OSError if it cannot be opened."""
    if path.name.startswith("."):
        return "hidden"
    if path.exists() and not path.is_file():
        return "not a regular file: a pipe, a socket or a device"
    inner = path.with_suffix("") if path.suffix.lower() == PACKED else path
    suffix = inner.suffix.lower()
    if suffix in UNREAD:
        return UNREAD[suffix]
    if suffix not in SUFFIXES:
        return f"a spectrum has one of the suffixes {' '.join(sorted(SUFFIXES))}"
    if suffix not in TEXT:
        return None
    try:
        return _other_text(beginning_of(path, BEGINNING))
    except Unreadable:
        return None  # a damaged spectrum


def _other_text(beginning: bytes) -> str | None:
    text = text_bytes(beginning)
    if len(beginning) >= BEGINNING:
        text = text[: text.rfind(b"\n") + 1] or text
    dialect = find(text)
    if dialect is not None:
        names = dialect.headings
        spectral = any(AXIS.search(name) or COUNTER.search(name) for name in names)
        if dialect.columns == 2 or not names or spectral:
            return None
        return _no_header(dialect.above[-1])
    told = [line for _, _, raw in lines_of(text) if (line := shown(raw)) and line[0] not in "#%"]
    if not told or not re.match(r"\W*[a-z]", told[0], re.I | re.A):
        return None  # empty, one column of numbers, or damaged
    if HEADING.match(told[0].lstrip("\"' ")):
        return None
    return _no_header(told[0])


def _no_header(line: str) -> str:
    return f"its first line is not a spectrum's header: {line[:SHOWN]!r}"
