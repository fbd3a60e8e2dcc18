"""Sort points into classes by their concentrations, and suggest a mineral by its ideal composition.

Concentrations need no rule of what is bright beside what: a class is compared with ideal formulas in
wt %, in units of the errors that a calibration gives and of how far natural minerals are from them.
"""

from dataclasses import replace

import numpy as np

from ...lines.formula import PART, WEIGHT
from ...spectrum.spectrum import FloatArray, IntArray
from ..points.contents import Contents
from ..points.points import Points
from .classify import LEAST_PART, Classes, Names, classify
from .minerals import UNNAMED

LEAST = 2  # elements: fewer tell no composition
# What natural minerals are off by: a part of an ideal concentration, and wt %.
NATURAL, TRACES = 0.12, 0.3
FITS, APART = 2.0, 4.0  # errors that each element may be off; in chi2, from the next mineral
MINERALS = """
spodumene LiAlSi2O6; petalite LiAlSi4O10; eucryptite LiAlSiO4; lepidolite KLi2AlSi4O10F2;
amblygonite LiAlPO4F; zinnwaldite KLiFeAl2Si3O10F2; muscovite KAl3Si3O12H2; biotite KMg2FeAlSi3O12H2;
K-feldspar KAlSi3O8; albite NaAlSi3O8; anorthite CaAl2Si2O8; quartz SiO2; beryl Be3Al2Si6O18;
schorl NaFe3Al6B3Si6O31H4; almandine Fe3Al2Si3O12; olivine Mg2SiO4; diopside CaMgSi2O6; kaolinite Al2Si2O9H4;
calcite CaCO3; dolomite CaMgC2O6; magnesite MgCO3; siderite FeCO3; apatite Ca5P3O12F; fluorite CaF2;
hematite Fe2O3; magnetite Fe3O4; pyrite FeS2; chalcopyrite CuFeS2; cassiterite SnO2; zircon ZrSiO4
"""


def ideal(formula: str) -> dict[str, float]:
    """wt % by element of a formula such as LiAlSi2O6."""
    mass = {symbol: WEIGHT[symbol] * int(n or 1) for symbol, n in PART.findall(formula)}
    return {symbol: 100 * one / sum(mass.values()) for symbol, one in mass.items()}


IDEAL = {
    name: ideal(formula)
    for name, formula in (one.split() for one in MINERALS.replace("\n", " ").split(";"))
}


def by_composition(points: Points, n_classes: int | None = None) -> tuple[Points, Classes] | None:
    """The points with wt % in place of areas, and their classes; None with fewer than two elements.

    An element below the limit of detection counts as none. Raises ValueError as `classify` does.
    """
    told = (
        np.any([one.known for one in points.contents.values()], axis=0) if points.contents else None
    )
    used = [
        name
        for name, one in points.contents.items()
        if np.mean(np.nan_to_num(one.value) > 0) >= LEAST_PART
    ]
    if told is None or len(used) < LEAST:
        return None
    value = {name: _value(points.contents[name]) for name in points.contents}
    error = {name: points.contents[name].error for name in points.contents}
    alike = replace(
        points, area=value, area_error=error, line_nm={}, total=np.where(told, 1.0, np.nan), contents={}
    )  # fmt: skip
    return alike, classify(alike, tuple(used), n_classes, _named)


def _value(one: Contents) -> FloatArray:
    return np.where(np.isfinite(one.value), one.value, np.where(one.below, 0.0, one.low))


def _named(points: Points, label: IntArray, k: int) -> Names:
    return [likely(*_mean(points, label == c)) for c in range(k)]


def _mean(points: Points, own) -> tuple[dict[str, float], dict[str, float]]:
    """Mean of each element, and its error: the usual one of a point, as a calibration errs in all alike."""
    mean, error = {}, {}
    for name, value in points.area.items():
        known = own & np.isfinite(value)
        if known.any():
            mean[name] = float(value[known].mean())
            told = points.area_error[name][known]
            error[name] = float(np.nanmean(told)) if np.isfinite(told).any() else 0.0
    return mean, error


def likely(mean: dict[str, float], error: dict[str, float]) -> tuple[str, str]:
    """The mineral whose ideal composition the means, wt %, are near, and why; unnamed where none is, or two
    are, and where nothing that it is made of was measured."""
    found = []
    for name, formula in IDEAL.items():
        measured = formula.keys() & mean.keys()
        if len(measured) < LEAST and not formula.keys() - measured <= {"O"}:
            continue
        off = [
            (value - formula.get(e, 0.0))
            / np.sqrt(error[e] ** 2 + TRACES**2 + (NATURAL * formula.get(e, 0.0)) ** 2)
            for e, value in mean.items()
        ]
        found.append((float(np.sum(np.square(off))), float(np.max(np.abs(off))), name))
    found.sort()
    if not found or found[0][1] > FITS or (len(found) > 1 and found[1][0] - found[0][0] < APART):
        return UNNAMED, ""
    name = found[0][2]
    beside = [
        f"{e} {value:.3g} ± {error[e]:.2g} ({IDEAL[name].get(e, 0.0):.3g})"
        for e, value in mean.items()
    ]
    return name, f"wt % (ideal): {', '.join(beside)}"
