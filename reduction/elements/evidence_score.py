"""Weigh the evidence for one element: lines present, missing, too weak, or another element's.

The weight is a logarithm of odds: how much more likely the peaks are if the element emits with a
certain brightness than if its lines coincide with peaks, or miss them, by chance.
"""

from typing import NamedTuple

import numpy as np

from ..spectrum.kernel import kernel, part_kernel
from ..spectrum.spectrum import FloatArray, IntArray

CANDIDATES = 8  # of the strongest lines that are there: each proposes a brightness
LOG_AREA_RANGE = 5.0  # chance peaks are spread over so many e-folds of area
WORST = -4.0  # one line cannot say more than this against an element
RESONANT_WORST = -1.5  # nor this, where it absorbs its own light
RESONANT_EV = 1.5  # lower level below which a strong line may do so
LOG_LEFT = -0.9  # ln of the part of a peak that others must leave, for it to be evidence
ALMOST = -0.35  # lines this far (in ln) below the limit may still show
MISSING_SPREAD = 0.5
NOT_SEEN, IN_A_CROWD, BAD = -1, -2, -3
LEAST_SHARE = 0.05  # of a peak, below which a line does not explain it
HIDDEN, WEAKER = 0.25, 0.02  # a stronger peak may hide the line; a weaker one may not
LOG_HIDDEN, LOG_WEAKER = float(np.log(HIDDEN)), float(np.log(WEAKER))
NEVER = 40.0  # ln of how unlikely it is that a line and a peak agree: nothing beside those
TWO_PI = 2.0 * float(np.pi)  # of two normal laws: of ln(area), and of the place in errors


class Lines(NamedTuple):
    """What is expected and seen of each line, shape (entries,), element after element.

    log_area: ln of the area for one atom; low_ev: lower level; spread: of ln(area) that the line's
    own data allow; peak: its index, or NOT_SEEN, IN_A_CROWD, BAD; away: distance in errors;
    log_limit: ln of the area from which it should be seen; log_hidden: from which it would show in
    the light at its place. stretch: of the axis, counted from 0, and against: what missing lines of
    a stretch say at the most, (stretches,). hidden: spread of ln(area) within which a line may be
    missing.
    """

    log_area: FloatArray
    low_ev: FloatArray
    spread: FloatArray
    peak: IntArray
    away: FloatArray
    log_limit: FloatArray
    log_hidden: FloatArray
    stretch: IntArray
    against: FloatArray
    hidden: FloatArray


class Peaks(NamedTuple):
    """Of each peak, shape (k,): how many fall by chance on one error of the place; ln(area), its error."""

    chance: FloatArray
    log_area: FloatArray
    relative: FloatArray


@kernel
def evidence_score(begin, end, lines, peaks, log_free):
    """The best weight of an element whose lines are begin..end, and ln of its brightness.

    log_free: ln of what others leave of each peak.
    """
    best, best_scale = -1e9, -1e9
    tried = 0
    dark = np.empty(len(lines.against))
    for j in range(begin, end):
        i = lines.peak[j]
        if i < 0:
            continue
        if log_free[i] < peaks.log_area[i] + LOG_LEFT:
            continue
        tried += 1
        if tried > CANDIDATES:
            break
        scale = log_free[i] - lines.log_area[j]
        # Twice: the lines that agree move the proposal to their mean.
        for _ in range(2):
            weight, better = _at(scale, begin, end, lines, peaks, log_free, dark)
            if weight > best:
                best, best_scale = weight, scale
            if better == scale:  # no line agrees: the same again
                break
            scale = better
    return best, best_scale


@part_kernel
def _at(scale, begin, end, lines, peaks, log_free, dark):
    log_area, low_ev, spread, peak, away, log_limit, log_hidden, stretch, against, hidden = lines
    dark.fill(0.0)
    chance, log_peak, relative = peaks
    total, mean, sure = 0.0, 0.0, 1e-9
    for j in range(begin, end):
        log_expected = log_area[j] + scale
        above = log_expected - log_limit[j]
        if above < ALMOST:
            continue
        i = peak[j]
        if i == BAD:
            continue
        worst = RESONANT_WORST if low_ev[j] < RESONANT_EV else WORST
        if i < 0:
            beyond = log_expected - log_hidden[j]
            if beyond > 0.0:
                z = beyond / hidden[j]
                dark[stretch[j]] += max(worst, -0.5 * z * z) * (0.3 if i == IN_A_CROWD else 1.0)
            continue
        if log_free[i] < log_peak[i] + LOG_LEFT:
            z = (log_expected - log_peak[i]) / (2 * spread[j])
            if z > 0.5:
                total += max(worst, -0.5 * z * z)
            continue
        s = np.sqrt(spread[j] ** 2 + relative[i] ** 2)
        r = log_free[i] - log_expected
        wide = s
        if r < 0.0 and low_ev[j] < RESONANT_EV:
            wide = np.sqrt(s * s + 0.6**2)
        unlike = 0.5 * (r / wide) ** 2 + 0.5 * away[j] ** 2
        if unlike > NEVER:
            total += max(LOG_HIDDEN if r > 0.0 else LOG_WEAKER, worst)
            continue
        by_chance = chance[i] / LOG_AREA_RANGE
        likely = np.exp(-unlike) / (wide * TWO_PI * by_chance)
        total += max(np.log(0.75 * likely + (HIDDEN if r > 0.0 else WEAKER)), worst)
        if abs(r) < 1.5 * wide:
            mean += (scale + r) / (wide * wide)
            sure += 1.0 / (wide * wide)
    for s in range(len(dark)):
        total += max(dark[s], against[s])
    return total, (mean / sure if mean != 0.0 else scale)


@kernel
def evidence_scores(first, lines, peaks, log_free):
    """The weight and ln of the brightness of every element; first: where its lines begin."""
    n = len(first) - 1
    weight, scale = np.empty(n), np.empty(n)
    for e in range(n):
        weight[e], scale[e] = evidence_score(first[e], first[e + 1], lines, peaks, log_free)
    return weight, scale


@kernel
def accept(first, lines, peaks, area, prior, least, weight, scale):
    """Accept the most certain element, subtract its share of the peaks, reweigh the others, repeat.

    weight, scale: of each element by itself, as of `evidence_scores`; changed in place. Returns
    them, those accepted (most certain first), and the explained
    area of each peak. An element is only weighed again when it comes to the top.
    """
    log_free = peaks.log_area.copy()
    taken = np.zeros(len(area))
    weight += prior
    n = len(weight)
    open_, fresh = np.ones(n, np.bool_), np.ones(n, np.bool_)
    accepted = np.empty(n, np.int64)
    found = 0
    while True:
        e = -1
        for other in range(n):
            if open_[other] and (e < 0 or weight[other] > weight[e]):
                e = other
        if e < 0 or weight[e] < least:
            break
        if fresh[e]:
            accepted[found] = e
            found += 1
            open_[e] = False
            take(first[e], first[e + 1], scale[e], lines, area, taken)
            for i in range(len(area)):
                log_free[i] = np.log(max(area[i] - taken[i], 1e-6 * area[i]))
            fresh.fill(False)
            continue
        weight[e], scale[e] = evidence_score(first[e], first[e + 1], lines, peaks, log_free)
        weight[e] += prior[e]
        fresh[e] = True
    for e in range(n):
        if open_[e] and not fresh[e] and weight[e] > 0.5 * least:
            weight[e], scale[e] = evidence_score(first[e], first[e + 1], lines, peaks, log_free)
            weight[e] += prior[e]
    return weight, scale, accepted[:found].copy(), taken


@kernel
def take(begin, end, scale, lines, area, taken):
    """Assign an element the part of each peak that it explains: all of it if the areas agree."""
    for j in range(begin, end):
        i = lines.peak[j]
        if i < 0:
            continue
        log_expected = lines.log_area[j] + scale
        expected = np.exp(log_expected)
        if expected <= LEAST_SHARE * area[i]:
            continue
        agrees = np.log(area[i]) - log_expected < 2.0 * lines.spread[j]
        taken[i] += area[i] if agrees else expected
    for i in range(len(area)):
        taken[i] = min(taken[i], area[i])


@kernel
def best_entries(first, log_area, which):
    """The strongest line of each element that is not in a bad channel, or its first."""
    best = first[:-1].copy()
    for e in range(len(best)):
        highest = -np.inf
        for j in range(first[e], first[e + 1]):
            if which[j] != BAD and log_area[j] > highest:
                highest, best[e] = log_area[j], j
    return best
