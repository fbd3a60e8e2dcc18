"""Make maps, classes, tables and figures of a folder: the work of `labrun map`."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..maps.checks import read_checks
from ..maps.classes.classify import Classes, classify
from ..maps.classes.composition import by_composition
from ..maps.points.gather import gather
from ..maps.points.points import Points
from .choices import MapChoices, Shown, elements_to_show
from .figures import draw_figures
from .grades import SENTENCES, sample_grades
from .sample_figures import concentrations_shown
from .tables import BY_WT, write_classes, write_grades, write_maps, write_record


@dataclass(frozen=True, slots=True, eq=False)
class MapResult:
    """The results. classes: None if the points give none; notes: sentences for the user."""

    points: Points
    elements: list[str]
    classes: Classes | None
    notes: list[str]
    written: list[Path]


def map_folder(folder: Path, out: Path, choices: MapChoices | None = None) -> MapResult:
    """Read `folder`, write into `out` (created if missing).

    Raises Unreadable or ValueError, with a sentence, if the folder has nothing to map, and OSError
    if `out` cannot be written.
    """
    choices = choices or MapChoices()
    points = gather(folder, correct_drift=choices.correct_drift)
    if not points.lit.any():
        known = any(np.isfinite(area).any() for area in points.area.values())
        what = "every area in it is 0" if known else "it has no numeric area"
        raise ValueError(f"{folder} has nothing to map: {what}")
    shown = elements_to_show(points, choices) if points.area else Shown([])
    notes = [*points.notes, *shown.notes]
    classes = None
    try:
        classes = classify(points, choices.features, choices.n_classes)
        notes += classes.notes
    except ValueError as fault:
        notes.append(f"no classes: {fault}")
    composed = None
    try:
        composed = by_composition(points, choices.n_classes)
        notes += [] if composed is None else [_composed(composed[1])]
    except ValueError as fault:
        notes.append(f"no classes by wt %: {fault}")
    notes += _about_places(points)
    notes += [one.sentence for one in read_checks(folder)]
    notes += [
        f"{e}: {n} of {len(points)} points are above the standards of the calibration; what their "
        "curves say is in maps.csv"
        for e in concentrations_shown(points, choices)
        if (n := points.contents[e].counts()["above_range"])
    ]
    grades = sample_grades(points, classes, choices)
    notes += [one.sentence for one in grades[:SENTENCES]]
    out.mkdir(parents=True, exist_ok=True)
    written = [write_maps(points, shown.elements, choices, out)]
    if classes is not None:
        written += write_classes(points, classes, out)
    if composed is not None:
        written += write_classes(*composed, out, BY_WT)
    written += [write_grades(grades, out)] if grades else []
    written += draw_figures(points, shown.elements, classes, composed, grades, choices, out)
    written.append(
        write_record(points, shown.elements, classes, choices, notes, written, folder, out)
    )
    return MapResult(points, shown.elements, classes, notes, written)


def _composed(classes: Classes) -> str:
    """`3 classes by wt % of Li, K: 1 spodumene (12 points), ...`."""
    each = [f"{one.number} {one.likely} ({one.size} points)" for one in classes.summary]
    return f"{len(classes)} classes by wt % of {', '.join(classes.features)}: {', '.join(each)}"


def _about_places(points: Points) -> list[str]:
    single = [
        sample or "the only sample"
        for sample in sorted(set(points.sample))
        if points.of_sample(sample).sum() == 1
    ]
    return [f"{name} has one point: a table but no map" for name in single]
