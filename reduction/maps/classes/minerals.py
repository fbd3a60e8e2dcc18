"""Suggest the mineral of a lithium pegmatite that a class may be, from its bright elements.

Brightness is relative: a point is bright in an element from 0.35 of the mean area of the class that
is brightest in it, and only an element that differs between the classes tells anything; a trace (1
% of the class's brightest element) is bright nowhere. A class is bright if 80 % of its points are,
and not bright if 80 % are not; a mixture is neither, and gets no name. Micas are told from feldspar
by hydrogen, or by the ratio Al / Si (1 in muscovite, 1/3 in feldspars): bright from 1.4 times its
median over the classes that have aluminium at all. So a name is a suggestion about the classes of
one map, from lines that absorb themselves, and no analysis.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...spectrum.spectrum import FloatArray, IntArray

BRIGHT, MOSTLY = 0.35, 0.8
TELLS = 0.5  # the dimmest class has less than this part of the brightest
TRACE = 0.01  # of the brightest element of a class: what is nowhere above it is bright nowhere
RATIO, RATIO_BRIGHT = "Al/Si", 1.4
HAS_ALUMINIUM = 0.2  # of the brightest class
UNNAMED = "unnamed"

Bright = dict[str, bool]


@dataclass(frozen=True, slots=True)
class Rule:
    """A mineral, what is bright in it, and what is not."""

    mineral: str
    bright: tuple[str, ...]
    dim: tuple[str, ...]

    @property
    def why(self) -> str:
        said = [f"{' and '.join(self.bright)} bright"] if self.bright else []
        return ", ".join([*said, f"{' and '.join(self.dim)} not"])


RULES = (
    Rule("lepidolite", ("Li", "K"), ("Na",)),
    Rule("spodumene", ("Li",), ("K", "Na")),
    Rule("muscovite", ("K", RATIO), ("Li", "Na")),
    Rule("muscovite", ("K", "H"), ("Li", "Na")),
    Rule("K-feldspar", ("K",), ("Li", "Na", "H", RATIO)),
    Rule("albite", ("Na",), ("Li", "K")),
    Rule("quartz", (), ("Li", "K", "Na", "Al")),
)
"""Tried in this order; a rule applies only if all its elements were measured and are clear."""


def likely(bright: Bright) -> tuple[str, str]:
    """The likely mineral of a class, and why; ('unnamed', '') if no rule fits."""
    for rule in RULES:
        if all(e in bright for e in (*rule.bright, *rule.dim)) and (
            all(bright[e] for e in rule.bright) and not any(bright[e] for e in rule.dim)
        ):
            return rule.mineral, rule.why
    return UNNAMED, ""


def brightness(areas: Mapping[str, FloatArray], label: IntArray, k: int) -> list[Bright]:
    """Elements bright (True) and not bright (False) in each of k classes; unclear ones are left out.

    areas: by element, counts nm, shape (n,), NaN where unknown. label: class of each point.
    """
    found: list[Bright] = [{} for _ in range(k)]
    means = {element: _means(area, label, k) for element, area in areas.items()}
    top = np.max([np.nan_to_num(mean) for mean in means.values()], axis=0, initial=0.0)
    for element, area in areas.items():
        mean = means[element]
        if not np.isfinite(mean).all():
            continue
        trace = not np.any(mean > TRACE * top)
        tells = trace or mean.min() < TELLS * mean.max()
        least = np.inf if trace else BRIGHT * mean.max()
        _judge(found, element, area, label, least if tells else None)
    if "Al" in areas and "Si" in areas:
        _judge_ratio(found, areas["Al"], areas["Si"], label, k)
    return found


def _judge_ratio(found: list[Bright], al: FloatArray, si: FloatArray, label, k: int) -> None:
    mean = _means(al, label, k)
    ratio = np.divide(al, si, out=np.full(len(al), np.nan), where=si > 0)
    each = _means(ratio, label, k)
    there = np.isfinite(each) & (mean > HAS_ALUMINIUM * np.nanmax(mean, initial=0.0))
    if there.any():
        _judge(found, RATIO, ratio, label, RATIO_BRIGHT * float(np.median(each[there])))


def _judge(found: list[Bright], name: str, values, label, least: float | None) -> None:
    if least is None:
        return
    for c, bright in enumerate(found):
        own = values[(label == c) & np.isfinite(values)]
        part = float(np.mean(own >= least)) if len(own) else 0.5
        if part >= MOSTLY or part <= 1 - MOSTLY:
            bright[name] = part >= MOSTLY


def _means(values: FloatArray, label: IntArray, k: int) -> FloatArray:
    known = np.isfinite(values) & (label >= 0)
    count = np.bincount(label[known], minlength=k)
    total = np.bincount(label[known], values[known], minlength=k)
    return np.divide(total, count, out=np.full(k, np.nan), where=count > 0)
