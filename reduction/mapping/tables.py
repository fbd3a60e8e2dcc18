"""Write the tables of a map: maps.csv, classes.csv, class_summary.csv, and map.json beside them."""

import csv
import hashlib
import json
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from ..maps.checks import Checks
from ..maps.classes.classify import NONE, Classes
from ..maps.grade import Grade
from ..maps.points.contents import ERROR, FLAGS, HIGH, LOW, VALUE, Contents
from ..maps.points.points import Points
from ..maps.points.scales import UNITS, on_scale
from .choices import MapChoices
from .grades import SampleGrade
from .sample_figures import concentrations_shown

MAPS, CLASSES, SUMMARY, RECORD = "maps.csv", "classes.csv", "class_summary.csv", "map.json"
CHECKS, GRADES = "checks.csv", "grade.csv"
DIGITS = 7
BY_WT = "_by_wt_percent"  # ends the names of what is of classes by composition
VERSIONS = ("labrun", "numpy", "scipy", "matplotlib")


def write_maps(points: Points, elements: list[str], choices: MapChoices, folder: Path) -> Path:
    """One row per point and element: coordinates, the value on the requested scale, the area, and the
    concentration where a calibration was used."""
    x, y = (f"{axis}_{points.unit}" for axis in "xy")
    head = ["sample", "point", x, y, "element", "line_nm", "value", "area", "area_err"]
    calibrated = concentrations_shown(points, choices)
    head += [VALUE, ERROR, LOW, HIGH, FLAGS] if calibrated else []
    rows = []
    for element in dict.fromkeys([*elements, *calibrated]):
        shown = element in elements
        nothing = np.full(len(points), np.nan)
        value = on_scale(points, element, choices.scale) if shown else nothing
        area = points.area.get(element, nothing)
        error = points.area_error.get(element, nothing)
        line = points.line_nm.get(element, float("nan"))
        rows += [
            [
                *_point(points, at), element, cell(line),
                *map(cell, (value[at], area[at], error[at])),
                *(_content(points.contents.get(element), at) if calibrated else ()),
            ]
            for at in range(len(points))
        ]  # fmt: skip
    return _write(folder / MAPS, head, rows)


def _content(one: Contents | None, at: int) -> list[str]:
    if one is None:
        return [""] * 5
    return [*map(cell, (one.value[at], one.error[at], one.low[at], one.high[at])), one.flags[at]]


def write_classes(points: Points, classes: Classes, folder: Path, which: str = "") -> list[Path]:
    """One row per point with its class from 1, `none` without a signal; and one row per class.

    which: ends the files' names.
    """
    x, y = (f"{axis}_{points.unit}" for axis in "xy")
    head = ["sample", "point", x, y, "class", "distance", "silhouette"]
    rows = []
    for at, label in enumerate(classes.label.tolist()):
        number = "none" if label == NONE else str(label + 1)
        away, inside = classes.distance[at], classes.silhouette[at]
        rows.append([*_point(points, at), number, cell(away), cell(inside)])
    elements = sorted(points.area)
    long = ["class", "points", "silhouette", "likely", "why"]
    long += [name for e in elements for name in (e, f"{e}_err")]
    summary = [
        [s.number, s.size, cell(s.silhouette), s.likely, s.why]
        + [cell(v) for e in elements for v in (s.area[e], s.error[e])]
        for s in classes.summary
    ]
    paths = [folder / name.replace(".csv", f"{which}.csv") for name in (CLASSES, SUMMARY)]
    return [_write(paths[0], head, rows), _write(paths[1], long, summary)]


def write_checks(checks: Sequence[Checks], folder: Path) -> Path:
    """One row per standard and element: what was found and known, and whether the calibration holds."""
    head = ["standard", "element", "checks", "wt_percent", "wt_percent_err", "wt_percent_known"]
    head += ["off_in_errors", "drift_percent", "drift_chance", "holds", "verdict"]
    rows = []
    for one in checks:
        drift = (float("nan"),) * 2 if one.drift is None else (100 * one.drift[0], one.drift[1])
        mean = one.values.mean() if len(one.values) else float("nan")
        off = float("nan") if one.off is None else one.off
        rows.append([
            one.standard, one.element, len(one.found), *map(cell, (mean, one.error_of_one, one.known)),
            *map(cell, (off, *drift)), "yes" if one.holds else "no", one.sentence,
        ])  # fmt: skip
    return _write(folder / CHECKS, head, rows)


def write_grades(grades: Sequence[SampleGrade], folder: Path) -> Path:
    """A row for each sample's element as a whole, for each class in it, and for each strip along its axis."""
    head = [
        "sample",
        "element",
        "of",
        "from",
        "to",
        "points",
        "below_lod",
        "above_range",
        "not_measured",
    ]
    head += ["wt_percent", "wt_percent_err", "err_of_calibration", "err_of_variation", "at_least"]
    rows = []
    for one in grades:
        named = [("all", "", "", one.whole)]
        named += [(f"class {k + 1}", "", "", found) for k, found in one.by_class.items()]
        named += [(one.axis, cell(s.start), cell(s.end), s.grade) for s in one.strips]
        rows += [
            [one.sample, one.element, of, start, end, *_grade(found)]
            for of, start, end, found in named
        ]
    return _write(folder / GRADES, head, rows)


def _grade(one: Grade) -> list:
    counts = [one.points, one.below, one.above, one.unmeasured]
    numbers = (one.mean, one.error, one.of_calibration, one.of_variation)
    return [*counts, *map(cell, numbers), "yes" if one.at_least else ""]


def write_record(
    points: Points, elements: list[str], classes: Classes | None, choices: MapChoices,
    notes: list[str], written: list[Path], folder: Path, out: Path,
) -> Path:  # fmt: skip
    """What was done, the inputs (with sha256), and the results; deterministic."""
    record: dict[str, Any] = {
        "points": len(points),
        "placed": int(points.placed.sum()),
        "samples": sorted({s for s in points.sample if s}),
        "unit": points.unit,
        "elements": {e: _plain(points.line_nm.get(e)) for e in elements},
        "scale": choices.scale,
        "unit_of_values": UNITS[choices.scale],
        "concentrations": {
            element: points.contents[element].counts()
            for element in concentrations_shown(points, choices)
        },
        "classes": None if classes is None else _classes(classes),
        "notes": notes,
        "inputs": {
            path.relative_to(folder).as_posix(): sha256(path) for path in sorted(points.inputs)
        },
        "written": {path.name: sha256(path) for path in sorted(written)},
        "versions": {name: _version(name) for name in VERSIONS},
    }
    path = out / RECORD
    path.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    return path


def _classes(classes: Classes) -> dict[str, Any]:
    return {
        "features": list(classes.features),
        "number": len(classes),
        "silhouette": {str(k): round(score, 6) for k, score in classes.scores.items()},
        "chosen_by": "silhouette" if classes.scores else "given",
        "likely": {str(s.number): s.likely for s in classes.summary},
    }


def _point(points: Points, at: int) -> list[str]:
    return [points.sample[at], points.name[at], cell(points.x[at]), cell(points.y[at])]


def cell(value: float) -> str:
    """A number with seven digits, empty if it is not a number."""
    return f"{float(value):.{DIGITS}g}" if np.isfinite(value) else ""


def sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _plain(value: float | None) -> float | None:
    return None if value is None else round(value, 4)


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""


def _write(path: Path, head: list[str], rows: list[list]) -> Path:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(head)
        writer.writerows(rows)
    return path
