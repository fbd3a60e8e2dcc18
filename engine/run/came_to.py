"""By what a run is found again: its parameters, its samples, and the numbers that it came to."""

import csv
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from ...schemas.quantity import number_text
from ...system.cells import bare
from ..journal.encode import QUANTITY_KEY

SAMPLE = "sample"
LONGEST = 200
MOST_SAMPLES = 500
LARGEST_TABLE = 20_000_000
"""Bytes; what a larger table comes to is for the reduction to say."""


def brief(params: Mapping[str, Any]) -> dict[str, Any]:
    """Parameters as in the journal, without those that are longer than anybody searches for."""
    return {name: value for name, value in params.items() if len(str(value)) <= LONGEST}


def value_text(value: Any) -> str:
    """A value as in the journal, as people write it: `0.2 mm`, `1 mm, 2 mm`."""
    if isinstance(value, dict) and QUANTITY_KEY in value:
        magnitude, unit = value[QUANTITY_KEY]
        return f"{number_text(magnitude)} {unit.replace(' / ', '/')}".rstrip()
    if isinstance(value, list):
        return ", ".join(map(value_text, value))
    if isinstance(value, dict):
        return ", ".join(f"{name} {value_text(one)}" for name, one in value.items())
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: ""}[value]
    return number_text(value) if isinstance(value, float) else str(value)


def samples(folder: Path, params: Mapping[str, Any]) -> list[str]:
    """What it was measured on: its parameter `sample`, and every value of columns of that name."""
    told = params.get(SAMPLE)
    found = {told: None} if isinstance(told, str) and told else {}
    for _, header, rows in _tables(folder):
        if SAMPLE in header:
            at = header.index(SAMPLE)
            found |= dict.fromkeys(bare(row[at]) for row in rows if len(row) > at and row[at])
    return list(found)[:MOST_SAMPLES]


def values(folder: Path, outputs: Mapping[str, Any]) -> dict[str, tuple[float, str]]:
    """Name -> number and unit: outputs, and the mean of each column of numbers as `TABLE.COLUMN`."""
    found: dict[str, tuple[float, str]] = {}
    for name, value in outputs.items():
        number, unit = (
            value.get(QUANTITY_KEY, (None, "")) if isinstance(value, dict) else (value, "")
        )
        if isinstance(number, int | float) and not isinstance(number, bool):
            found[name] = (float(number), unit)
    for table, header, rows in _tables(folder):
        for name, mean in _means(header, rows).items():
            found[f"{table}.{name}"] = (mean, "")
    return found


def _means(header: list[str], rows: Iterable[list[str]]) -> dict[str, float]:
    sums: dict[str, tuple[float, int] | None] = dict.fromkeys(header[1:-1], (0.0, 0))
    for row in rows:
        for name, cell in zip(header[1:-1], row[1:], strict=False):
            known = sums[name]
            if known is None or cell == "":
                continue
            try:
                sums[name] = (known[0] + float(cell), known[1] + 1)
            except ValueError:
                sums[name] = None  # a column of words
    means = {name: of[0] / of[1] for name, of in sums.items() if of is not None and of[1]}
    return {name: mean for name, mean in means.items() if abs(mean) < float("inf")}


def _tables(folder: Path) -> Iterator[tuple[str, list[str], Iterator[list[str]]]]:
    """Name without `.csv`, header and rows of each table that the run has collected."""
    for path in sorted(folder.glob("data*.csv")):
        try:
            if path.stat().st_size > LARGEST_TABLE:
                continue
            with path.open(encoding="utf-8", newline="") as file:
                rows = csv.reader(file)
                yield path.stem, next(rows, []), rows
        except (OSError, ValueError, csv.Error):
            continue  # shown by another program, or damaged: the journal has its rows
