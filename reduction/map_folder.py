"""Make maps, classes, tables and figures of a folder: all that `labrun map` does."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .classes.classify import Classes, classify
from .map_choices import MapChoices, elements_to_show
from .map_figures import draw_figures
from .map_tables import write_classes, write_maps, write_record
from .points.gather import gather
from .points.points import Points


@dataclass(frozen=True, slots=True, eq=False)
class MapResult:
    """What came out. classes: None where the points tell none; notes: sentences for a person."""

    points: Points
    elements: list[str]
    classes: Classes | None
    notes: list[str]
    written: list[Path]


def map_folder(folder: Path, out: Path, choices: MapChoices | None = None) -> MapResult:
    """Read `folder`, write into `out` (made if need be).

    Raises Unreadable or ValueError, with a sentence, where nothing can be made of the folder, and
    OSError where `out` does not take what is written.
    """
    choices = choices or MapChoices()
    points = gather(folder)
    if not points.lit.any():
        known = any(np.isfinite(area).any() for area in points.area.values())
        what = "every area in it is 0" if known else "there is no area in it that is a number"
        raise ValueError(f"{folder} has nothing to map: {what}")
    shown = elements_to_show(points, choices)
    notes = [*points.notes, *shown.notes]
    classes = None
    try:
        classes = classify(points, choices.features, choices.n_classes)
        notes += classes.notes
    except ValueError as fault:
        notes.append(f"no classes: {fault}")
    notes += _about_places(points)
    out.mkdir(parents=True, exist_ok=True)
    written = [write_maps(points, shown.elements, choices, out)]
    if classes is not None:
        written += write_classes(points, classes, out)
    written += draw_figures(points, shown.elements, classes, choices, out)
    written.append(
        write_record(points, shown.elements, classes, choices, notes, written, folder, out)
    )
    return MapResult(points, shown.elements, classes, notes, written)


def _about_places(points: Points) -> list[str]:
    single = [
        sample or "the only sample"
        for sample in sorted(set(points.sample))
        if points.of_sample(sample).sum() == 1
    ]
    return [f"{name} has one point: a table and no map" for name in single]
