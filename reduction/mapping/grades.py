"""Grades of all samples and calibrated elements of a map, along the longer side of each sample."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..figures.line_scan import line_scan_figure
from ..maps.classes.classify import Classes
from ..maps.grade import Grade, Strip, along, by_class
from ..maps.points.points import Points
from ..spectrum.spectrum import FloatArray
from .choices import MapChoices
from .sample_figures import Drawn, concentrations_shown, samples_of, slug

LEAST = 3  # points of a sample
SENTENCES = 3  # grades that are said; lithium's is among them


@dataclass(frozen=True, slots=True)
class SampleGrade:
    """Of one element in one sample. axis: x or y, along which its strips lie."""

    sample: str
    element: str
    whole: Grade
    by_class: dict[int, Grade]
    axis: str
    strips: list[Strip]

    @property
    def sentence(self) -> str:
        """The grade of the whole, and what its error is made of."""
        one, name = self.whole, f"{self.sample}: " if self.sample else ""
        return (
            f"{name}{self.element} grade {one.said}; of the error {one.of_calibration:.2g} is the "
            f"calibration's and {one.of_variation:.2g} the sample's variation"
        )


def sample_grades(
    points: Points, classes: Classes | None, choices: MapChoices
) -> list[SampleGrade]:
    """Of samples of some points, element by element, lithium first."""
    found = []
    for sample, own in samples_of(points).items():
        if own.sum() < LEAST:
            continue
        axis = "x" if np.ptp(points.x[own]) >= np.ptp(points.y[own]) else "y"
        place = points.x if axis == "x" else points.y
        for element in concentrations_shown(points, choices):
            contents = points.contents[element]
            whole, strips = along(contents, own, place)
            if whole.points:
                of = {} if classes is None else by_class(contents, own, classes.label)
                found.append(SampleGrade(sample, element, whole, of, axis, strips))
    return sorted(found, key=lambda one: one.element != "Li")


def grade_figures(grades: list[SampleGrade], unit: str) -> Iterator[Drawn]:
    """The grade of each sample along its axis; nothing of one with fewer than three strips."""
    for sample in dict.fromkeys(one.sample for one in grades):
        own = [one for one in grades if one.sample == sample and len(one.strips) >= LEAST]
        if own:
            yield f"grade{slug(sample)}", partial(_profile, own, unit)


def _profile(grades: list[SampleGrade], unit: str):
    strips = grades[0].strips
    middle = np.array([(one.start + one.end) / 2 for one in strips])
    ends = {rf"$\bf{{{g.element}}}$": drawn_ends([s.grade for s in g.strips]) for g in grades}
    value, error, least, most = ({name: one[k] for name, one in ends.items()} for k in range(4))
    return line_scan_figure(
        middle - middle[0], value, unit, error, None, "grade (wt %)", least, most, grades[0].axis
    )


def drawn_ends(strips: list[Grade]) -> FloatArray:
    """What is drawn of each strip: mean, error, lower end, upper end; shape (4, n), NaN where there is none.

    A strip of which all is below LOD has an upper end alone, one that is at least something a lower one.
    """
    nothing = float("nan")
    return np.array([
        (nothing, nothing, nothing, 2 * one.mean) if 0 < one.points == one.below
        else (nothing, nothing, one.mean, nothing) if one.at_least
        else (one.mean, one.error, nothing, nothing)
        for one in strips
    ]).T  # fmt: skip
