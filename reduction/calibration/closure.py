"""Concentrations without standards: the amounts of the Saha-Boltzmann plot, closed to 100 %.

Calibration-free LIBS (Ciucci et al., Appl. Spectrosc. 53, 960 (1999)): the plasma is taken to have
the sample's composition, and all that the sample holds to have lines in the plot, oxygen excepted,
which a rock's cations bind in a known ratio. An element that is not seen for sure gets an upper limit.

A plasma is not one zone, and not one moment: part of its atoms are in cooler ones, where what ionises
easily shines far more. How many the lines tell somewhat (`plasma.cool_part`): amounts are drawn many times,
each part as often as is its odds, and what is told is the mean, the standard deviation and the
quantiles of the draws. Where the response is told by the same lines, two zones are one picture of several:
half of the draws are of one zone and all that may be cool, and all go as far toward what rocks are made of as
the lines leave open.

One standard of the same instrument makes up for what all spectra lack alike, response and transition
probabilities (one-point calibration: Cavalcanti et al., Spectrochim. Acta B 87, 51 (2013)); there a
factor for each line, here one for each element's amount.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ..elements.evidence_score import NOT_SEEN
from ..elements.identify import Identified, known_density
from ..elements.merged import without_merged
from ..lines.formula import WEIGHT, Closed, with_oxygen
from ..plasma.boltzmann import CALIBRATION, Bend, fit_plot
from ..plasma.cool_part import CoolPart, cool_parts
from ..plasma.lithium_share import THICK, UNIFORM, cations
from ..plasma.response import LEVEL, stiffness
from ..plasma.strengths import atoms
from ..reduce import Reduction
from ..spectrum.response import KnownResponse
from ..spectrum.spectrum import BoolArray, FloatArray, IntArray, TextArray
from .calibration import Concentration, OnePoint
from .rocks import ELEMENTS, of_rocks

NORMAL_95 = 1.96
MOST_ERROR = 1.5  # of ln(amount): with more an element's amount is not told
# Part of the atoms that are in a cooler zone where the lines do not tell it (a response had to be found in
# them, or a standard is there): its ends, even in ln; the zone's temperature and density beside the plot's.
COOL_PARTS = np.geomspace(0.005, 0.6, 9)
COOL_K, COOL_NE = 0.5, 0.3
# Where lines scatter more than their errors around all that is fitted, what that leaves of each ln(amount):
# so many times how much more. All that is told then is by so much less sure: what such a model lacks, its
# elements share, and to take it for errors of each alone goes too far toward usual rocks. Chosen on 52
# measured minerals, meteorites and basalts; looked at on 51 others.
NOT_EXPLAINED, LESS_SURE = 1.2, 1.6
# Mean square of what lines are off by, in their errors, up to which two zones and a response that were fitted
# to them explain them: of made plasmas 0.4 to 0.96, of measured ones 0.98 to 1.8.
EXPLAINED = 0.95
# One in so many draws is of two zones and a response that were fitted to the same lines: each of the two
# pictures is wrong about other elements (made rocks and vices that chose, measured minerals).
BENT_SHARE = 2
TWO_THICK = 0.5  # of what one zone lacks in thick lines, what two lack
# What is known beforehand where the response has to be found in the same lines: one sample in five is a rock
# (`rocks`), the others have its main elements within a factor of five; the lines say which.
ROCKS, ELSE_SPREAD = 0.2, 1.6
LEANS = 0.5  # of the error that the lines leave; an amount that this moves by more says so
SURELY = 3.0  # ln of the odds that a level response and a cool part make the lines, and not another response
NO_SEAMS = np.empty(0)
MOST_SCATTER = 2.0  # of ln(area); a line further off is another's
LEAST_SHOTS = 3  # whose scatter is an error
# e-folds by which the cool parts of a sample and of the only standard differ: as makes errors of sodium and
# potassium right on half of the made rocks, where it is 0.5.
UNLIKE = 0.7
TWO = (
    2**0.5
)  # fits, the standard's and the sample's: a factor's error where scatter does not tell it
DRAWS = 1_800


@dataclass(frozen=True, slots=True, eq=False)
class _Amounts:
    """ln(mass) of the plot's elements, arbitrary unit, shape (n,), with the covariance of the plot's fit.
    counted: whose mass is known and which are no gas. lost: e-folds of light lost. cool: what is added to
    ln(mass) for each of COOL_PARTS, shape (parts, n); of the middle one it is in log_mass already."""

    names: TextArray
    counted: BoolArray
    log_mass: FloatArray
    covariance: FloatArray
    lost: FloatArray
    cool: FloatArray


def _found(reduction: Reduction) -> Identified | None:
    found = reduction.identified
    return None if found is None else without_merged(found, reduction.profiles)


def _amounts(found: Identified | None) -> _Amounts | None:
    if found is None or found.plot is None or found.lines is None:
        return None
    plot = found.plot
    names = atoms().elements[plot.names]
    counted = cations(plot.names) & np.array([name in WEIGHT for name in names])
    if not counted.any():
        return None
    log_mass = plot.log_scale[plot.names] + np.log([WEIGHT.get(name, 1.0) for name in names])
    cool = _cool(found, len(names))
    usual = cool[len(cool) // 2]
    return _Amounts(
        names, counted, log_mass + usual, plot.covariance, _lost(found, len(names)), cool - usual
    )


def _beside(found: Identified, known: KnownResponse) -> Identified:
    """The plot fitted again with a response that is level but for what the known one may be off by, where one
    of its own had been found in the lines; as it was where there is no plot."""
    plot, lines, bend = found.plot, found.lines, found.bend
    if plot is None or lines is None or bend is None:
        return found
    if plot.response is not None:
        lines = replace(lines, log_area=lines.log_area + plot.response.at(lines.vacuum_nm))
    at = bend.knots_nm
    error = np.interp(at, known.wavelength_nm, np.nan_to_num(known.error))
    beside = np.diag(error**2) + np.linalg.inv(stiffness(at, NO_SEAMS, LEVEL))
    bend = Bend(at, np.zeros(len(at)), np.asarray(np.linalg.inv(beside), np.float64))
    again = fit_plot(
        lines, known_density(found.hydrogen), plot.temperature_k, bend=bend, scattered=True
    )
    if again is None or again.response is None:
        return found
    lines = replace(lines, log_area=lines.log_area - again.response.at(lines.vacuum_nm))
    return replace(found, plot=again, lines=lines, bend=bend, response=again.response)


def _cool(found: Identified, n: int) -> FloatArray:
    """ln of each element's amount with parts of its atoms in a cooler zone, less that with none there:
    (parts, n)."""
    plot, lines = found.plot, found.lines
    assert plot is not None and lines is not None
    (which, weight), density = _by_element(found), 10**plot.log10_ne
    hot = lines.thin(plot.temperature_k, density)
    cool = lines.thin(COOL_K * plot.temperature_k, COOL_NE * density)
    part = COOL_PARTS[:, None]
    more = np.logaddexp(np.log(1 - part) + hot, np.log(part) + cool) - hot
    total = np.maximum(np.bincount(which, weight, n), 1e-12)
    return -np.array([np.bincount(which, weight * one, n) for one in more]) / total


def _by_element(found: Identified) -> tuple[IntArray, FloatArray]:
    """Which of the plot's elements each line is of, and what it weighs; both (lines,)."""
    plot, lines = found.plot, found.lines
    assert plot is not None and lines is not None
    return np.searchsorted(plot.names, lines.element), 1 / (lines.error**2 + CALIBRATION**2)


def one_point(
    standards: Sequence[tuple[Mapping[str, float], Sequence[Reduction]]],
) -> dict[str, OnePoint]:
    """What the shots of one standard or more tell of each element: (wt % by element, reductions) of each.

    ln(known / found), up to what all elements of a shot share, which a closure does not need.
    """
    told: dict[str, list[tuple[float, float, float, int]]] = {}
    for sample, (wt_percent, shots) in enumerate(standards):
        for shot in shots:
            found = _amounts(_found(shot))
            if found is None:
                continue
            own = found.counted & np.array([wt_percent.get(name, 0.0) > 0 for name in found.names])
            if own.sum() < 2:
                continue
            known = np.log([wt_percent[name] for name in found.names[own]])
            factor = known - found.log_mass[own]
            # As a mean over the mass, so that the element of which there is most is the steadiest.
            factor = factor - np.average(factor, weights=np.exp(known))
            fitted = np.sqrt(np.diag(found.covariance)[own])
            for name, *each in zip(found.names[own], factor, fitted, found.lost[own], strict=True):
                told.setdefault(str(name), []).append((each[0], each[1], each[2], sample))
    points = {}
    for name, rows in told.items():
        factor, fitted, lost, sample = np.array(rows).T
        enough = len(rows) >= LEAST_SHOTS
        error = float(factor.std(ddof=1)) if enough else TWO * float(np.median(fitted))
        points[name] = OnePoint(
            float(np.median(factor)), error, float(np.median(lost)), len(set(sample.tolist()))
        )
    return points


def concentrations(
    reduction: Reduction, closed: Closed, points: Mapping[str, OnePoint] | None = None
) -> dict[str, Concentration]:
    """wt % by element, with standard errors and 95 % intervals; empty where no plot tells amounts.

    ln(amount) has the covariance of the plot, and for each element what one zone in equilibrium
    lacks. Intervals are of the logit of the mass fraction, so that they end within 0 and 100 %.
    points: of a one-point calibration, by element.
    """
    found, known = _found(reduction), reduction.response is not None
    if reduction.response is not None and found is not None and not points:
        found = _beside(found, reduction.response)
    told = _amounts(found)
    if found is None or told is None:
        return {}
    names, counted, log_mass = told.names, told.counted, told.log_mass
    sure = counted & np.isin(names, reduction.detected)
    doubtful = counted & ~sure
    counted = sure if sure.any() else counted
    bound = np.array([with_oxygen(name, closed) for name in names])
    own, leans = np.hypot(UNIFORM, THICK * told.lost), np.zeros(len(names), dtype=bool)
    if points:
        if found.response is not None:
            own = np.hypot(own, _beyond(found))
        own, covariance = _by_standards(told, points, own)
        log_drawn = log_mass + _drawn(covariance)  # a standard's plasma had cooler zones, too
    else:
        rock = sure & np.isin(names, ELEMENTS) & (closed == "oxides")
        log_drawn, covariance, beyond, leans = _of_zones(found, told, rock, known)
        log_mass, own = log_drawn.mean(axis=0), np.hypot(own, beyond)
    counted = _told_well(log_mass + np.log(bound), covariance, counted)
    if not counted.any():
        return {}
    log_bound = log_drawn + np.log(bound)
    maybe = doubtful & (np.sqrt(np.diag(covariance)) < MOST_ERROR)
    log_bound[:, ~(counted | maybe)] = -np.inf
    log_bound[::2, maybe & ~counted] = -np.inf  # it is there or not, and nothing tells
    log_whole = np.logaddexp.reduce(log_bound, axis=1, keepdims=True)
    parts = 100 * np.exp(np.minimum(log_drawn - log_whole, 0.0))
    flags = _missing(reduction, names[counted])
    uncalibrated = ("no standard told it",) if points else ()
    said = {}
    for k in np.flatnonzero(counted):
        doubt = () if sure[k] else ("uncertain",)
        doubt += () if names[k] in (points or {}) else uncalibrated
        doubt += ("in part from usual rocks",) if leans[k] else ()
        low, high = np.quantile(parts[:, k], [0.025, 0.975])
        said[str(names[k])] = Concentration(
            float(parts[:, k].mean()), float(parts[:, k].std()), float(low), float(high), (*doubt, *flags)
        )  # fmt: skip
    for k in np.flatnonzero(doubtful & ~counted):
        if (high := float(np.quantile(parts[:, k], 0.975))) < 100:
            said[str(names[k])] = Concentration(None, None, None, high, ("below LOD", "uncertain"))
    return said | _limits(found, said, float(log_whole.mean()), float(own.mean()))


def _by_standards(
    told: _Amounts, points: Mapping[str, OnePoint], own: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """What standards leave of each ln(amount), (n,), and its covariance with the plot's, (n, n); their
    factors are put into told.log_mass."""
    own, unlike = own.copy(), np.zeros(len(told.names))
    heat = np.ptp(told.cool, axis=0) / np.log(COOL_PARTS[-1] / COOL_PARTS[0])
    for k, name in enumerate(told.names.tolist()):
        if name in points:
            point = points[name]
            told.log_mass[k] += point.log_factor
            thicker = THICK * (told.lost[k] - point.lost)
            own[k] = float(np.sqrt(UNIFORM**2 + thicker**2 + point.error**2))
            if point.standards == 1:  # several show by their scatter what one cannot
                unlike[k] = UNLIKE * heat[k]
        else:
            own[k] = np.hypot(own[k], np.std([one.log_factor for one in points.values()]))
    # A factor's scatter from shot to shot has the plot's own in it.
    fitted = np.isin(told.names, list(points), invert=True)
    covariance = told.covariance * np.outer(fitted, fitted) + np.diag(own**2)
    return own, covariance + np.outer(unlike, unlike)


def _of_zones(
    found: Identified, told: _Amounts, rock: BoolArray, known: bool
) -> tuple[FloatArray, FloatArray, float, BoolArray]:
    """Draws of ln(mass) of the plot's elements, of one zone and of two, (DRAWS, n); their covariance, (n, n);
    what neither explains, of each; and which usual rocks have moved by much of their error, (n,). rock: of
    which elements they tell something, (n,). known: whether a response was divided out."""
    plot, lines, bend = found.plot, found.lines, found.bend
    assert plot is not None and lines is not None and bend is not None
    parts, level = cool_parts(lines, plot, bend), True
    if known:
        level = min(part.scatter for part in parts) <= EXPLAINED
    elif found.response is not None:
        stiff = stiffness(bend.knots_nm, NO_SEAMS, LEVEL)
        straight = cool_parts(lines, plot, replace(bend, stiff=stiff))
        level = _best(straight) > _best(parts) + SURELY
        parts = straight if level else parts
    # A level response is given up only where lines scatter more than they may by chance.
    most = 1.0 + (2.0 / len(lines)) ** 0.5 if level else EXPLAINED
    explained = min(part.scatter for part in parts) <= most
    beyond, thick = 0.0 if explained else _beyond(found), THICK * told.lost
    drawn = _of_two_zones(found, parts, np.hypot(TWO_THICK * thick, beyond))
    leans = np.zeros(len(rock), dtype=bool)
    if not level:
        pair = np.arange(DRAWS) // 2  # what is not certain is in every second draw
        one = pair % BENT_SHARE > 0 if explained else pair >= 0
        covariance = told.covariance + np.diag(UNIFORM**2 + thick**2 + beyond**2)
        of_one = told.log_mass + _drawn(covariance) + np.resize(told.cool, drawn.shape)
        by_lines = np.where(one[:, None], of_one, drawn)
        drawn = _as_rocks(by_lines, told.names, rock)
        moved = (drawn - by_lines).mean(axis=0)
        leans = rock & (
            abs(moved - np.median(moved[rock] if rock.any() else 0)) > LEANS * by_lines.std(axis=0)
        )
    covariance, middle = np.atleast_2d(np.cov(drawn.T)), drawn.mean(axis=0)
    if not explained:
        drawn = middle + LESS_SURE * (drawn - middle)
    return drawn, covariance, LESS_SURE * beyond, leans


def _as_rocks(drawn: FloatArray, names: TextArray, rock: BoolArray) -> FloatArray:
    """Draws of ln(mass), (DRAWS, n), with what rocks tell of the elements `rock` beside each other: each
    draw goes as far toward them as both are known (Evensen, J. Geophys. Res. 99, 10143 (1994)). Rocks and
    other samples have as many of the draws as they are likely with these lines."""
    k = int(rock.sum())
    if k < 2:
        return drawn
    # The level of all is not known: differences, as orthogonal directions.
    among = np.linalg.svd(np.eye(k) - 1.0 / k)[0][:, : k - 1]
    mean, together = of_rocks(tuple(names[rock].tolist()))
    usual = mean @ among
    kinds = [among.T @ together @ among, ELSE_SPREAD**2 * np.eye(k - 1)]
    shares, off = drawn[:, rock] @ among, drawn - drawn.mean(axis=0)
    off_shares = off[:, rock] @ among
    of_lines, away = off_shares.T @ off_shares / len(drawn), usual - shares.mean(axis=0)
    log_odds = np.log([ROCKS, 1 - ROCKS])
    for n, kind in enumerate(kinds):
        both = of_lines + kind
        log_odds[n] -= 0.5 * (np.linalg.slogdet(both)[1] + away @ np.linalg.solve(both, away))
    part = float(1.0 / (1.0 + np.exp(np.clip(log_odds[1] - log_odds[0], -50, 50))))
    half = len(drawn) // 2
    is_rock = np.tile(np.random.default_rng(1).permutation(half) < round(part * half), 2)
    found = drawn.copy()
    for kind, own in zip(kinds, (is_rock, ~is_rock), strict=True):
        gain = np.linalg.solve(of_lines + kind, off_shares.T @ off / len(drawn))
        toward = usual + _normal(k - 1)[::-1][own] @ np.linalg.cholesky(kind).T
        found[own] += (toward - shares[own]) @ gain
    return found


def _best(parts: list[CoolPart]) -> float:
    return max(part.evidence for part in parts)


def _of_two_zones(found: Identified, parts: list[CoolPart], own: FloatArray) -> FloatArray:
    """Draws of ln(mass) of the plot's elements, each cool part as often as is its odds; (DRAWS, n). own:
    errors of each beside the fit's, (n,)."""
    plot = found.plot
    assert plot is not None
    names = atoms().elements[plot.names]
    weight = np.log([WEIGHT.get(name, 1.0) for name in names.tolist()])
    half = (np.arange(DRAWS // 2) + 0.5) / (DRAWS // 2)
    last = np.searchsorted(np.cumsum([part.odds for part in parts])[:-1], half)
    which, drawn = np.concatenate([last, last]), np.empty((DRAWS, len(names)))
    for k in np.unique(which):
        covariance = parts[k].covariance + np.diag(own**2)
        drawn[which == k] = parts[k].log_scale + _drawn(covariance)[which == k]
    return drawn + weight


def _told_well(log_mass: FloatArray, covariance: FloatArray, counted: BoolArray) -> BoolArray:
    """Which of those counted have a part of the whole with a bearable error, (n,)."""
    counted = counted.copy()
    while counted.any():
        # What is not counted may be any number, too great a one for exp.
        parts = np.exp(np.where(counted, log_mass - log_mass[counted].max(), -np.inf))
        turn = np.eye(len(parts)) - parts / parts.sum()
        error = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", turn, covariance, turn), 0.0))
        if not np.any(error[counted] > MOST_ERROR):
            break
        # The one that the lines tell least would make all the others as unsure.
        counted[np.argmax(np.where(counted, np.diag(covariance), -1.0))] = False
    return counted


def _drawn(covariance: FloatArray) -> FloatArray:
    """Draws around 0 with a covariance (n, n), shape (DRAWS, n); each time the same ones."""
    size, axes = np.linalg.eigh(covariance)
    return _normal(len(size)) * np.sqrt(np.maximum(size, 0.0)) @ axes.T


@lru_cache(maxsize=32)
def _normal(n: int) -> FloatArray:
    half = np.random.default_rng(0).standard_normal((DRAWS // 2, n))
    return np.concatenate([half, -half])


def _lost(found: Identified, n: int) -> FloatArray:
    """e-folds of light that each element's lines lost to self-absorption, in the mean; (n,)."""
    plot, lines = found.plot, found.lines
    assert plot is not None and lines is not None
    which = np.searchsorted(plot.names, lines.element)
    log_kept = -np.log(np.maximum(plot.kept, 1e-12))
    return np.bincount(which, log_kept, n) / np.maximum(np.bincount(which, minlength=n), 1)


def _beyond(found: Identified) -> float:
    """Error of each ln(amount), as ln(area) of lines scatters around the plot beyond their own errors."""
    plot, lines = found.plot, found.lines
    assert plot is not None and lines is not None
    off = np.clip(plot.residual, -MOST_SCATTER, MOST_SCATTER)
    scatter = max(float(np.mean(off**2 - lines.error**2 - CALIBRATION**2)), 0.0) ** 0.5
    return NOT_EXPLAINED * scatter


def _missing(reduction: Reduction, names) -> tuple[str, ...]:
    """A sentence on detected elements that the plot has no line of: the closure lacks them."""
    gone = [
        name
        for name in reduction.detected
        if name in WEIGHT
        and name not in names
        and cations(np.searchsorted(atoms().elements, [name]))[0]
    ]
    return (f"closed without {' '.join(sorted(gone))}",) if gone else ()


def _limits(
    found: Identified, said: dict[str, Concentration], log_whole: float, error: float
) -> dict[str, Concentration]:
    """Of elements that were not accepted: what their clearest missing line could hide, wt %."""
    limits = {}
    first = found.catalogue.first
    for e, name in enumerate(atoms().elements.tolist()):
        own = np.arange(first[e], first[e + 1])
        own = own[found.matched.peak[own] == NOT_SEEN]
        unseen = name not in said and name in WEIGHT and e not in found.indexed.accepted
        if not (unseen and len(own) and cations(np.array([e]))[0]):
            continue
        log_amount = float(np.min(found.matched.log_limit[own] - found.effective[own]))
        log_part = log_amount + np.log(WEIGHT[name]) - log_whole + NORMAL_95 * error
        high = 100 * np.exp(min(log_part, 1.0))
        if high < 100:
            limits[name] = Concentration(None, None, None, float(high), ("below LOD",))
    return limits
