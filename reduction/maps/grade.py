"""The grade of a sample: its mean concentration with an error, as a whole, by class and along an axis.

A point below the limit of detection is anywhere between 0 and its upper limit, and counts as half of that.
What a calibration errs it errs in all points alike, so the usual error of a point stays in the mean; to it
comes how the points vary, by strips across the axis where these tell more than single points do: grains are
larger than the step between points.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..spectrum.spectrum import BoolArray, FloatArray, IntArray
from .points.contents import Contents

STRIPS = 20  # at most, along the axis
LEAST_STRIPS = 4  # whose means tell how a sample varies
UNIFORM = 12**-0.5  # standard deviation of what is anywhere between 0 and 1


@dataclass(frozen=True, slots=True)
class Grade:
    """Of one element, wt %: mean with its standard error, which is that of the calibration, of the sample's
    variation and of points below LOD together; NaN where nothing was measured, the error also of one point
    without one. how many points were measured, of these below LOD and above the standards, and how many
    were not measured. at_least: points above the standards told no value but a lower end."""

    mean: float
    error: float
    of_calibration: float
    of_variation: float
    points: int
    below: int
    above: int
    unmeasured: int
    at_least: bool

    @property
    def said(self) -> str:
        """`1.21 ± 0.13 wt % (mean of 441 points, 12 of them below LOD)`."""
        counted = [f"mean of {self.points} points"]
        for n, what in (
            (self.below, "of them below LOD"), (self.above, "of them above the standards"),
            (self.unmeasured, "more not measured"),
        ):  # fmt: skip
            counted += [f"{n} {what}"] if n else []
        least = "at least " if self.at_least else ""
        return f"{least}{self.mean:.3g} ± {self.error:.2g} wt % ({', '.join(counted)})"


@dataclass(frozen=True, slots=True)
class Strip:
    """Part of a sample along its axis, from one coordinate to another."""

    start: float
    end: float
    grade: Grade


def grade(contents: Contents, own: BoolArray, strips: Sequence[BoolArray] = ()) -> Grade:
    """Of the points `own` (n,). strips: parts of the sample whose means tell how it varies."""
    known = contents.known & own
    n = int(known.sum())
    value, error, half = _values(contents)
    if not n:
        nothing = float("nan")
        return Grade(nothing, nothing, nothing, nothing, 0, 0, 0, int(own.sum()), False)
    of_calibration = float(np.mean(error[known]))
    varied = float(np.std(value[known], ddof=1) / np.sqrt(n)) if n > 1 else 0.0
    means = [float(np.mean(value[known & one])) for one in strips if (known & one).any()]
    if len(means) >= LEAST_STRIPS:
        varied = max(varied, float(np.std(means, ddof=1) / np.sqrt(len(means))))
    hidden = float(np.sum(half[known]) / n)
    no_value = known & contents.above & ~np.isfinite(contents.value)
    return Grade(
        float(np.mean(value[known])), float(np.sqrt(of_calibration**2 + varied**2 + hidden**2)),
        of_calibration, varied, n, int((contents.below & ~contents.above & known).sum()),
        int((contents.above & known).sum()), int((own & ~contents.known).sum()), bool(no_value.any()),
    )  # fmt: skip


def _values(contents: Contents) -> tuple[FloatArray, FloatArray, FloatArray]:
    """What each point counts as, its error, and the error that a point below LOD leaves to a mean."""
    told = np.isfinite(contents.value)
    limit = np.nan_to_num(contents.high)
    value = np.where(told, contents.value, np.where(contents.below, limit / 2, contents.low))
    error = np.where(told, np.nan_to_num(contents.error), 0.0)
    half = np.where(~told & contents.below, limit * UNIFORM, 0.0)
    return np.nan_to_num(value), error, half


def along(contents: Contents, own: BoolArray, place: FloatArray) -> tuple[Grade, list[Strip]]:
    """The grade of a sample and of each strip of it; place (n,): of its points along the axis."""
    strips = list(_strips(own, place))
    whole = grade(contents, own, [mask for _, _, mask in strips])
    return whole, [Strip(a, b, grade(contents, mask)) for a, b, mask in strips]


def _strips(own: BoolArray, place: FloatArray) -> Iterator[tuple[float, float, BoolArray]]:
    low, high = float(place[own].min()), float(place[own].max())
    n = min(STRIPS, len(np.unique(np.round(place[own], 6))))
    edges = np.linspace(low, high, n + 1)
    which = np.clip(np.searchsorted(edges, place, side="right") - 1, 0, n - 1)
    for k in range(n):
        mask = own & (which == k)
        if mask.any():
            yield float(edges[k]), float(edges[k + 1]), mask


def by_class(contents: Contents, own: BoolArray, label: IntArray) -> dict[int, Grade]:
    """By class from 0, of the points that have one."""
    return {
        int(k): grade(contents, own & (label == k))
        for k in np.unique(label[own]).tolist()
        if k >= 0
    }
