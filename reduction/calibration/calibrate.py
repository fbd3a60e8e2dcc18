"""Make a calibration of standards' shots: which signal and which curve, by leaving standards out."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from ..elements.elements import Line
from ..reduce import Reduction
from ..spectrum.spectrum import BoolArray, FloatArray
from .calibration import AREA, LIGHT, ElementCalibration, Point, signal_of
from .curve import Curve, cross_validated, fit_curve
from .replicates import outliers, shot_scatter
from .signals import candidates, line_near, total_light
from .standards import Standards

LEAST_STANDARDS, LEAST_BENT = 3, 5
BENT_BETTER, LINE_BETTER = 0.9, 0.7  # of the error with a straight curve, with the predominant line
LEAST_SLOPE, LEAST_OF_OTHERS = 3.0, 5.0  # standard errors; of lines that are tried beside that one
BELOW_NOTHING = 3.0  # standard errors of a blank's signal
MOST_VARIED = 0.1  # relative spread of an internal standard's own concentration


@dataclass(frozen=True, slots=True)
class Shot:
    """One shot at a standard: its name in messages, and its reduction."""

    name: str
    reduction: Reduction


@dataclass(frozen=True, slots=True)
class Choices:
    """by: AREA, LIGHT or an internal standard's element, None for what cross-validates better of
    the first two. lines: wavelengths in air, nm, by element, the one that
    cross-validates best where not said. degree: 1 or 2, None for what
    cross-validates better."""

    by: str | None = None
    lines: Mapping[str, float] = field(default_factory=dict)
    degree: int | None = None


@dataclass(frozen=True, slots=True)
class Calibrated:
    """The curves; sentences on elements without one; shots left out, each with the reason."""

    elements: dict[str, ElementCalibration]
    refused: list[str]
    left_out: list[str]


def calibrate(
    standards: Standards, shots: Mapping[str, Sequence[Shot]], choices: Choices | None = None
) -> Calibrated:
    """Curves for all elements of the standards that have one. shots: by sample.

    Raises ValueError for a line or an internal standard that cannot be.
    """
    choices = choices or Choices()
    internal = _internal(standards, choices)
    refused: list[str] = []
    axis = next((s.reduction.profiles.wavelength_nm for own in shots.values() for s in own), [0, 0])
    range_nm = float(axis[0]), float(axis[-1])
    kept, left_out = _without_misfires(shots)
    elements: dict[str, ElementCalibration] = {}
    for element in standards.elements:
        known = {
            one.sample: one.wt_percent[element]
            for one in standards.samples
            if element in one.wt_percent and kept.get(one.sample)
        }
        why = _why_not(known)
        try:
            nm = choices.lines.get(element)
            lines = candidates(element, range_nm) if nm is None else [line_near(element, nm)]
        except ValueError as fault:
            if element in choices.lines:
                raise
            why, lines = why or str(fault), []
        if element == (internal and internal.element):
            why = "it is the internal standard"
        if why:
            refused.append(f"{element}: {why}")
            continue
        ways = (choices.by,) if choices.by else (AREA, LIGHT)
        degrees = (choices.degree,) if choices.degree else (1, 2)
        found = _best(known, kept, lines, ways, degrees, internal)
        if isinstance(found, str):
            refused.append(f"{element}: {found}")
        else:
            elements[element] = found[0]
            left_out += found[1]
    return Calibrated(elements, refused, left_out)


def _internal(standards: Standards, choices: Choices) -> Line | None:
    if choices.by in (None, AREA, LIGHT):
        return None
    known = [
        one.wt_percent[choices.by] for one in standards.samples if choices.by in one.wt_percent
    ]
    if known and np.ptp(known) > MOST_VARIED * np.mean(known):
        raise ValueError(
            f"{choices.by} cannot be the internal standard: the standards have {min(known):.4g} to "
            f"{max(known):.4g} wt % of it, and it has to be the same in all, unknown samples too"
        )
    return line_near(choices.by, choices.lines.get(choices.by))


def _why_not(known: Mapping[str, float]) -> str | None:
    """Why these standards make no curve."""
    values = sorted(set(known.values()))
    if len(known) < 2:
        n = "only one standard has" if known else "no standard with spectra has"
        return f"{n} a concentration of it; a curve needs {LEAST_STANDARDS} or more"
    if len(values) == 1:
        return f"all {len(known)} standards have the same concentration ({values[0]:.4g} wt %)"
    if len(known) < LEAST_STANDARDS or len(values) < LEAST_STANDARDS:
        return (
            f"{len(known)} standards of {len(values)} different concentrations; a curve with an "
            f"error needs {LEAST_STANDARDS} or more"
        )
    return None


def _without_misfires(
    shots: Mapping[str, Sequence[Shot]],
) -> tuple[dict[str, list[Shot]], list[str]]:
    """The shots without those whose total light is an outlier, and sentences on these."""
    light = [np.array([total_light(s.reduction) for s in own]) for own in shots.values()]
    far = outliers(light, [np.zeros(len(one)) for one in light])
    kept, left_out = {}, []
    for (sample, own), out, lights in zip(shots.items(), far, light, strict=True):
        kept[sample] = [shot for shot, bad in zip(own, out, strict=True) if not bad]
        left_out += _said(own, out, lights, f"the total light of {sample}")
    return kept, left_out


def _said(shots: Sequence[Shot], out: BoolArray, values: FloatArray, what: str) -> Iterable[str]:
    middle = float(np.median(values)) if len(values) else 0.0
    for k in np.flatnonzero(out).tolist():
        yield f"{shots[k].name}: {values[k]:.3g}, where {what} is {middle:.3g} (median)"


def _best(
    known: Mapping[str, float], shots: Mapping[str, Sequence[Shot]], lines: Sequence[Line],
    ways: Sequence[str], degrees: Sequence[int], internal: Line | None,
) -> tuple[ElementCalibration, list[str]] | str:  # fmt: skip
    """The curve that cross-validates best over standards, or why there is none."""
    found: list[tuple[float, ElementCalibration, list[str]]] = []
    why = "its line is out of range, full, or on bad channels in too many spectra"
    for line, by in product(lines, ways):
        measured = {
            sample: [
                (shot, told)
                for shot in shots[sample]
                if (told := signal_of(shot.reduction, line, by, internal)) is not None
            ]
            for sample in known
        }
        measured = {sample: own for sample, own in measured.items() if own}
        if len({known[sample] for sample in measured}) < LEAST_STANDARDS:
            continue
        areas = [np.array([told.area for _, told in own]) for own in measured.values()]
        noise = [np.array([told.noise for _, told in own]) for own in measured.values()]
        far = outliers(areas, noise)
        said = [
            sentence
            for (sample, own), out, one in zip(measured.items(), far, areas, strict=True)
            for sentence in _said(
                [s for s, _ in own], out, one, f"{line.element}'s {_name(by, internal)} of {sample}"
            )
        ]
        good = [one[~out] for one, out in zip(areas, far, strict=True)]
        floor, part = shot_scatter(good, [one[~out] for one, out in zip(noise, far, strict=True)])
        c = np.array([known[sample] for sample in measured])
        for degree in degrees:
            if degree == 2 and len(set(c.tolist())) < LEAST_BENT:
                continue
            least = LEAST_SLOPE if line is lines[0] else LEAST_OF_OTHERS
            one = _curve(list(measured), c, good, floor, part, degree, least)
            if isinstance(one, str):
                why = one if line is lines[0] else why
                continue
            curve, points = one
            bent, other = degree > min(degrees), line is not lines[0]
            score = _score(points) / (BENT_BETTER**bent * LINE_BETTER**other)
            error = np.array([p.cross_validated - p.wt_percent for p in points])
            made = ElementCalibration(
                line, _name(by, internal), internal, curve, float(c[c > 0].min()),
                curve.lod(), curve.loq(), float(np.sqrt(np.mean(error**2))), points,
            )  # fmt: skip
            found.append((score, made, said))
    if not found:
        return why
    _, best, said = min(found, key=lambda one: one[0])
    return best, said


def _name(by: str, internal: Line | None) -> str:
    return by if internal is None else f"ratio to {internal.element}"


def _curve(
    samples: list[str],
    c: FloatArray,
    good: Sequence[FloatArray],
    floor: float,
    part: float,
    degree: int,
    least_slope: float,
) -> tuple[Curve, tuple[Point, ...]] | str:
    mean = np.array([one.mean() for one in good])
    shots = np.array([len(one) for one in good], dtype=np.float64)
    curve = fit_curve(c, mean, shots, floor, part, degree)
    slope, error = curve.coefficients[1], curve.covariance[1][1] ** 0.5
    if slope < least_slope * error:
        return (
            f"its line does not grow with the concentration: {slope:.3g} ± {error:.2g} from 0 to "
            f"{curve.highest:.4g} wt %; choose another line with --line"
        )
    blank, blank_error = curve.coefficients[0], curve.covariance[0][0] ** 0.5
    if blank < -BELOW_NOTHING * np.hypot(blank_error, floor):
        return (
            f"a sample without it would show less than nothing, {blank:.3g} ± {blank_error:.2g}: the "
            "curve bends upwards there, or something is subtracted; add standards of little of it, or "
            "choose another line with --line"
        )
    if curve.lod() > curve.highest:
        return (
            f"its limit of detection, {curve.lod():.3g} wt %, is above the highest standard, "
            f"{curve.highest:.4g} wt %"
        )
    if degree == 2 and (curve.coefficients[2] >= 0 or curve.top < curve.highest):
        return "the curve bends the wrong way"
    left_out = cross_validated(curve, c, mean, shots)
    points = tuple(
        Point(sample, float(c[k]), float(mean[k]), float(good[k].std(ddof=1)) if shots[k] > 1 else None,
              int(shots[k]), float(left_out[k]))
        for k, sample in enumerate(samples)
    )  # fmt: skip
    return curve, points


def _score(points: Sequence[Point]) -> float:
    """Cross-validated error relative to the concentration, or to the median one where that is more."""
    c = np.array([p.wt_percent for p in points])
    told = np.array([p.cross_validated for p in points])
    usual = np.maximum(c, float(np.median(c[c > 0])))
    return float(np.sqrt(np.mean(((told - c) / usual) ** 2)))
