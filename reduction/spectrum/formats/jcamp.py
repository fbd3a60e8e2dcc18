"""JCAMP-DX with plain numbers (.jdx, .dx): McDonald and Wilks, Appl. Spectrosc. 42, 151 (1988).

Its compressed forms, in which letters stand for digits, are refused.
"""

import re

import numpy as np

from ..axis import unit_named
from ..columns import check_light
from ..fault import Unreadable
from ..readout import Readout
from ..spectrum import FloatArray
from ..text_bytes import shown

NAME = "a JCAMP-DX file"
BEGINS = re.compile(rb"\s*##\s*TITLE\s*=", re.I)
LABEL = re.compile(r"##([^=]*)=(.*)")
NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
DATA = ("XYDATA", "XYPOINTS", "PEAKTABLE")
EVEN, PAIRS = "(X++(Y..Y))", "(XY..XY)"
COMPRESSED = re.compile(r"[@%A-DF-Za-df-z]")


def begins(raw: bytes) -> bool:
    return BEGINS.match(raw) is not None


def read(raw: bytes) -> Readout:
    labels, data = _parts(shown(raw))
    form = re.sub(r"\s", "", data[0]).upper() if data else ""
    if len(data) < 2 or not form.startswith((EVEN, PAIRS)):
        raise Unreadable(f"{NAME} without a spectrum in it ({form[:30]!r}); export it as CSV")
    if any(COMPRESSED.search(line) for line in data[1:]):
        raise Unreadable(f"{NAME} in a compressed form; export it with plain numbers, or as CSV")
    rows = [[float(one) for one in NUMBER.findall(line)] for line in data[1:]]
    x, y = _even(labels, rows) if form.startswith(EVEN) else _pairs(labels, rows)
    check_light(labels.get("YUNITS", ""), NAME)
    unit = unit_named(labels.get("XUNITS", ""))
    return Readout(x, (y * _number(labels, "YFACTOR", 1.0))[None], unit)


def _parts(text: str) -> tuple[dict[str, str], list[str]]:
    """What the labels say, and the lines of the first table, its form first."""
    labels: dict[str, str] = {}
    data: list[str] = []
    within = False
    for line in text.splitlines():
        line = line.partition("$$")[0].strip()
        label = LABEL.match(line)
        if label is None:
            if within and line:
                data.append(line)
            continue
        name = re.sub(r"[\s\-/_]", "", label[1]).upper()
        within = name in DATA and not data
        if within:
            data.append(label[2].strip())
        labels.setdefault(name, label[2].strip())
    if "NTUPLES" in labels or labels.get("BLOCKS", "1") != "1":
        raise Unreadable(f"{NAME} with several spectra: export them one by one, or as text")
    return labels, data


def _even(labels: dict[str, str], rows: list[list[float]]) -> tuple[FloatArray, FloatArray]:
    """Counts at even steps, a wavelength before those of each line as a check."""
    y = np.array([count for row in rows for count in row[1:]])
    n = len(y)
    _check_number(labels, n)
    x = np.linspace(_number(labels, "FIRSTX"), _number(labels, "LASTX"), n)
    begin = np.cumsum([0, *(len(row) - 1 for row in rows)])[:-1]
    said = np.array([row[0] for row in rows]) * _number(labels, "XFACTOR", 1.0)
    step = abs(x[-1] - x[0]) / max(n - 1, 1)
    if n < 2 or np.any(np.abs(x[np.minimum(begin, n - 1)] - said) > 1.5 * step):
        raise Unreadable(f"{NAME} whose lines do not begin where their counts do: is it complete?")
    return x, y


def _pairs(labels: dict[str, str], rows: list[list[float]]) -> tuple[FloatArray, FloatArray]:
    flat = np.array([one for row in rows for one in row])
    if len(flat) % 2:
        raise Unreadable(f"{NAME} whose last wavelength has no counts: is it complete?")
    _check_number(labels, len(flat) // 2)
    return flat[::2] * _number(labels, "XFACTOR", 1.0), flat[1::2]


def _check_number(labels: dict[str, str], n: int) -> None:
    if round(_number(labels, "NPOINTS", n)) != n:
        raise Unreadable(
            f"{NAME} that promises {labels['NPOINTS']} points and has {n}: is it complete?"
        )


def _number(labels: dict[str, str], name: str, default: float | None = None) -> float:
    written = labels.get(name)
    if written is None and default is not None:
        return default
    try:
        return float(written or "")
    except ValueError:
        raise Unreadable(f"{NAME} whose {name} is {written!r}, not a number") from None
