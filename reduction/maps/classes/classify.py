"""Sort points into classes by the areas of a few elements, and summarise each class."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...spectrum.spectrum import FloatArray, IntArray
from ..points.points import Points
from .features import feature_table
from .kmeans import choose, split
from .minerals import brightness, likely
from .silhouette import silhouettes

FEATURES = ("Li", "H")  # the paper's
TELLING = ("Li", "H", "K", "Na", "Si")  # that tell the minerals of a lithium pegmatite apart
LEAST_PART = 0.01  # of the points must show a feature, or it tells nothing
NONE = -1
Names = list[tuple[str, str]]  # of each class: the likely mineral, and why


@dataclass(frozen=True, slots=True)
class ClassSummary:
    """One class: its number from 1, size, mean silhouette, and by element the mean area and its
    standard error (counts nm), and the likely mineral with the reason."""

    number: int
    size: int
    silhouette: float
    area: dict[str, float]
    error: dict[str, float]
    likely: str
    why: str


@dataclass(frozen=True, slots=True, eq=False)
class Classes:
    """label: class of each point from 0, NONE where a point has no signal; distance to the class's
    centre (scaled features) and silhouette, NaN for NONE; all (n,). scores: mean silhouette by
    number of classes tried, empty where the number was given."""

    features: tuple[str, ...]
    label: IntArray
    distance: FloatArray
    silhouette: FloatArray
    scores: dict[int, float]
    summary: list[ClassSummary]
    notes: list[str]

    def __len__(self) -> int:
        return len(self.summary)


def usual_features(points: Points) -> tuple[str, ...]:
    """Li and H if both are seen; else those of Li, H, K, Na and Si that are."""
    seen = tuple(e for e in TELLING if np.any(points.area.get(e, np.zeros(1)) > 0))
    return FEATURES if set(FEATURES) <= set(seen) else seen or FEATURES


def by_brightness(points: Points, label: IntArray, k: int) -> Names:
    """By what is bright in each of k classes."""
    return [likely(bright) for bright in brightness(points.area, label, k)]


def classify(
    points: Points,
    features: tuple[str, ...] | None = None,
    n_classes: int | None = None,
    named: Callable[[Points, IntArray, int], Names] = by_brightness,
) -> Classes:
    """Classes of all points with any signal, with likely minerals by `named`.

    features: elements, `usual_features` if None; n_classes: chosen by silhouette within 2 to 8 if
    None. Raises ValueError, with a sentence, where no feature tells anything or there are too few
    different points.
    """
    lit = points.lit
    notes = []
    if features is None:
        features = usual_features(points)
        if features != FEATURES:
            notes.append(
                f"Li and H are not both seen, so classes are based on {', '.join(features)}"
            )
    used = []
    for element in features:
        area = points.area.get(element)
        if area is None or not np.any(area[lit] > 0):
            notes.append(f"{element} is not seen anywhere, so it cannot separate classes")
        elif np.mean(area[lit] > 0) < LEAST_PART:
            notes.append(
                f"{element} is at less than 1 % of the points, too few to separate classes"
            )
        else:
            used.append(element)
    if not used:
        raise ValueError("; ".join([*notes, "there are no classes without a feature"]))
    x = feature_table([points.area[element][lit] for element in used])
    scores: dict[int, float] = {}
    if n_classes is None:
        n_classes, scores = choose(x)
    label = split(x, n_classes) if n_classes > 1 else np.zeros(len(x), dtype=np.int64)
    dark = int(np.sum(points.measured & ~lit))
    if dark:
        have = "a point has" if dark == 1 else f"{dark} points have"
        notes.append(f"{have} no signal, and no class")
    lost = int(np.sum(~points.measured))
    if lost:
        was = "a point was" if lost == 1 else f"{lost} points were"
        notes.append(f"{was} not measured, or failed")
    if n_classes == 1:
        notes.append("the points are all alike or too few: they are one class")
    inside = silhouettes(x, label)
    centre = np.array([x[label == c].mean(axis=0) for c in range(n_classes)])
    away = np.sqrt(np.sum((x - centre[label]) ** 2, axis=1))
    whole = _over(points, lit, label, NONE).astype(np.int64)
    silhouette = _over(points, lit, inside, np.nan)
    summary = _summaries(points, whole, silhouette, named(points, whole, n_classes))
    return Classes(
        tuple(used), whole, _over(points, lit, away, np.nan), silhouette, scores, summary, notes
    )


def _over(points: Points, lit, values, elsewhere: float) -> FloatArray:
    found = np.full(len(points), float(elsewhere))
    found[lit] = values
    return found


def _summaries(points: Points, label, silhouette, names: Names) -> list[ClassSummary]:
    found = []
    for c, (name, why) in enumerate(names):
        own = {e: _mean(area[label == c]) for e, area in points.area.items()}
        found.append(ClassSummary(
            c + 1, int(np.sum(label == c)), float(np.mean(silhouette[label == c])),
            {e: mean for e, (mean, _) in own.items()}, {e: error for e, (_, error) in own.items()},
            name, why,
        ))  # fmt: skip
    return found


def _mean(area: FloatArray) -> tuple[float, float]:
    """Mean and its standard error; NaN where too few are known."""
    known = area[np.isfinite(area)]
    n = len(known)
    error = float(np.std(known, ddof=1) / np.sqrt(n)) if n > 1 else float("nan")
    return (float(np.mean(known)) if n else float("nan")), error
