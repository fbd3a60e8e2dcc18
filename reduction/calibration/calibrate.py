"""Make a calibration of standards' shots: which signal and which curve, by leaving standards out."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any

import numpy as np

from ..elements.elements import Line
from ..reduce import Reduction
from ..spectrum.spectrum import BoolArray, FloatArray
from .calibration import AREA, LIGHT, WHOLE, ElementCalibration, Point, signal_of
from .curve import Curve, cross_validated, fit_curve
from .multivariate import Likeness, Pls, binned
from .replicates import outliers, shot_scatter
from .signals import candidates, line_near, total_light
from .standards import Standards

LEAST_STANDARDS, LEAST_BENT = 3, 5
BENT_BETTER, LINE_BETTER = 0.9, 0.7  # of the error with a straight curve, with the predominant line
PLS_BETTER = 0.9  # of the error of the best line
LEAST_SCATTER = 1e-3  # of a shot as a PLS model reads it, of the highest standard
LEAST_SLOPE, LEAST_OF_OTHERS = 3.0, 5.0  # standard errors; of lines that are tried beside that one
BELOW_NOTHING = 3.0  # standard errors of a blank's signal
BELOW_A_BLANK = "a sample without it would show less than nothing"
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
    cross-validates better. pls: whether an element is read from the whole spectrum; None: where that
    cross-validates clearly better, and nothing is said of lines. None and True need scikit-learn."""

    by: str | None = None
    lines: Mapping[str, float] = field(default_factory=dict)
    degree: int | None = None
    pls: bool | None = False

    @property
    def of_lines(self) -> bool:
        """Whether anything is said of lines and their curves."""
        return bool(self.by or self.lines or self.degree)


@dataclass(frozen=True, slots=True)
class Calibrated:
    """The curves; sentences on elements without one; shots left out, each with the reason; notes on
    standards; and how spectra are like the standards', where that was asked for."""

    elements: dict[str, ElementCalibration]
    refused: list[str]
    left_out: list[str]
    notes: list[str]
    likeness: Likeness | None = None


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
    whole = _Whole(kept, range_nm, choices)
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
        found = "" if choices.pls else _best(known, kept, lines, ways, degrees, internal)
        found = whole.better(known, found)
        if isinstance(found, str):
            refused.append(f"{element}: {found}")
        else:
            elements[element] = found[0]
            left_out += found[1]
    return Calibrated(elements, refused, left_out, *whole.likeness())


class _Whole:
    """Standards by their whole spectra, as far as these are asked for and enough."""

    def __init__(
        self, shots: Mapping[str, Sequence[Shot]], range_nm: tuple[float, float], choices: Choices
    ) -> None:
        asked = choices.pls or (choices.pls is None and not choices.of_lines)
        self.modelled = choices.pls is not False and range_nm[1] > range_nm[0]
        self.asked, self.always = bool(asked), bool(choices.pls)
        self.bins = {
            sample: np.array([binned(shot.reduction, range_nm) for shot in own])
            for sample, own in shots.items()
            if own and self.modelled
        }

    def better(
        self, known: Mapping[str, float], by_line: tuple[ElementCalibration, list[str]] | str
    ) -> tuple[ElementCalibration, list[str]] | str:
        """The element by a PLS model, if that is asked for or clearly better, else as it is by a line."""
        samples = [sample for sample in known if sample in self.bins]
        # What lines show to be wrong in the table, a regression with its own offset takes as it is.
        wrong = isinstance(by_line, str) and by_line.startswith(BELOW_A_BLANK)
        if not self.asked or wrong:
            return by_line
        if len(samples) < (least := _latent().LEAST):
            few = f"{len(samples)} standards; a PLS model needs {least} or more"
            return few if self.always else by_line
        c = np.array([known[sample] for sample in samples])
        fitted = _latent().fit_pls([self.bins[sample] for sample in samples], c)
        told = model_curve(samples, c, fitted)
        if isinstance(told, str):
            return told.partition(";")[0] if self.always else by_line
        curve, points = told
        if not isinstance(by_line, str) and _score(points) > PLS_BETTER * _score(by_line[0].points):
            return by_line
        return _made(None, WHOLE, None, curve, points, fitted.model), []

    def likeness(self) -> tuple[list[str], Likeness | None]:
        """Of spectra to the standards', and sentences on standards that are unlike the others."""
        if not self.modelled or len(self.bins) < _latent().LEAST:
            return [], None
        found = _latent().fit_likeness(list(self.bins.values()), list(self.bins))
        said = [
            f"{place.sample} is unlike the other standards: its {name} by components without it is "
            f"{value / limit:.1f} times the 99 % limit"
            for place in found.places
            for name, value, limit in (
                ("T2", place.t2, found.t2_limit),
                ("Q", place.q, found.q_limit),
            )
            if value > limit
        ]
        return said, found


def model_curve(
    samples: list[str], c: FloatArray, fitted: Any
) -> tuple[Curve, tuple[Point, ...]] | str:
    """The model as a curve: what it reads is the concentration, with the error of standards left out.

    A line through what it says of these would correct for less being known without them, which the model
    of all does not need. Each component costs a degree of freedom, as of a fit (ASTM E1655).
    """
    least = [np.full(len(one), LEAST_SCATTER * c.max()) for one in fitted.left_out]
    told = _curve(
        samples, c, fitted.left_out, *shot_scatter(fitted.left_out, least), 1, LEAST_SLOPE
    )
    if isinstance(told, str):
        return told
    points = tuple(replace(point, cross_validated=point.signal) for point in told[1])
    error = float(np.sqrt(np.mean([(point.signal - point.wt_percent) ** 2 for point in points])))
    highest, none = float(c.max()), (0.0, 0.0)
    freedom = max(len(c) - fitted.model.components - 1, 1)
    return Curve(highest, (0.0, highest), (none, none), 0.0, 0.0, error, 0.0, freedom), points


def _latent() -> Any:
    from . import latent  # here: it needs scikit-learn, of an extra of its own

    return latent


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
            made = _made(line, _name(by, internal), internal, curve, points)
            found.append((score, made, said))
    if not found:
        return why
    _, best, said = min(found, key=lambda one: one[0])
    return best, said


def _made(
    line: Line | None, by: str, internal: Line | None, curve: Curve, points: tuple[Point, ...],
    pls: Pls | None = None,
) -> ElementCalibration:  # fmt: skip
    error = np.array([p.cross_validated - p.wt_percent for p in points])
    lowest = min(p.wt_percent for p in points if p.wt_percent > 0)
    rmsecv = float(np.sqrt(np.mean(error**2)))
    return ElementCalibration(
        line, by, internal, curve, lowest, curve.lod(), curve.loq(), rmsecv, points, pls
    )


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
            f"{BELOW_A_BLANK}, {blank:.3g} ± {blank_error:.2g}: the "
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
