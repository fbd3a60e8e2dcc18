"""Weigh the evidence for one element: lines that are there, missing, too weak, or someone else's.

The weight is a logarithm of odds: how much likelier the peaks are if the element shines with a
certain brightness than if its lines fall on peaks, or beside them, by chance.
"""

import numpy as np

from .kernel import float_kernel

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
TWO_PI = 2.0 * float(np.pi)  # of two normal laws: of ln(area), and of the place in errors


@float_kernel
def weigh(
    begin,
    end,
    log_area,
    low_ev,
    spread,
    which,
    away,
    log_limit,
    density,
    log_peak,
    log_free,
    relative,
):
    """The best weight of an element whose lines are begin..end, and ln of its brightness.

    spread: of ln(area) that the line's own data allow. log_free: ln of what others leave of each peak.
    density: chance peaks for one error of the place.
    """
    best, best_scale = -1e9, -1e9
    tried = 0
    for j in range(begin, end):
        i = which[j]
        if i < 0:
            continue
        if log_free[i] < log_peak[i] + LOG_LEFT:
            continue
        tried += 1
        if tried > CANDIDATES:
            break
        scale = log_free[i] - log_area[j]
        # Twice: the lines that agree move the proposal to their mean.
        for _ in range(2):
            weight, better = _at(
                scale, begin, end, log_area, low_ev, spread, which, away, log_limit, density,
                log_peak, log_free, relative,
            )  # fmt: skip
            if weight > best:
                best, best_scale = weight, scale
            scale = better
    return best, best_scale


@float_kernel
def _at(
    scale,
    begin,
    end,
    log_area,
    low_ev,
    spread,
    which,
    away,
    log_limit,
    density,
    log_peak,
    log_free,
    relative,
):
    total, mean, sure = 0.0, 0.0, 1e-9
    for j in range(begin, end):
        log_expected = log_area[j] + scale
        above = log_expected - log_limit[j]
        if above < ALMOST:
            continue
        i = which[j]
        if i == BAD:
            continue
        worst = RESONANT_WORST if low_ev[j] < RESONANT_EV else WORST
        if i < 0:
            if above > 0.0:
                z = above / MISSING_SPREAD
                total += max(worst, -0.5 * z * z) * (0.3 if i == IN_A_CROWD else 1.0)
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
        chance = density[i] / LOG_AREA_RANGE
        likely = np.exp(-0.5 * (r / wide) ** 2 - 0.5 * away[j] ** 2) / (wide * TWO_PI * chance)
        other = 0.25 if r > 0.0 else 0.02  # a stronger peak may hide the line; a weaker one may not
        total += max(np.log(0.75 * likely + other), worst)
        if abs(r) < 1.5 * wide:
            mean += (scale + r) / (wide * wide)
            sure += 1.0 / (wide * wide)
    return total, (mean / sure if mean != 0.0 else scale)


@float_kernel
def weigh_all(
    first, log_area, low_ev, spread, which, away, log_limit, density, log_peak, log_free, relative
):
    """The weight and ln of the brightness of every element; first: where its lines begin."""
    n = len(first) - 1
    weight, scale = np.empty(n), np.empty(n)
    for e in range(n):
        weight[e], scale[e] = weigh(
            first[e], first[e + 1], log_area, low_ev, spread, which, away, log_limit, density,
            log_peak, log_free, relative,
        )  # fmt: skip
    return weight, scale


@float_kernel
def accept(
    first, log_area, low_ev, spread, which, away, log_limit, density, log_peak, relative, area,
    prior, least,
):  # fmt: skip
    """Believe the surest element, take its share of its peaks away, weigh the others anew, go on.

    Gives back weight and scale of each element, those accepted (surest first), and of each peak the
    area that they explain. An element is only weighed again when it comes to the top.
    """
    log_free = log_peak.copy()
    taken = np.zeros(len(area))
    weight, scale = weigh_all(
        first, log_area, low_ev, spread, which, away, log_limit, density, log_peak, log_free,
        relative,
    )  # fmt: skip
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
            take(first[e], first[e + 1], scale[e], log_area, spread, which, area, taken)
            for i in range(len(area)):
                log_free[i] = np.log(max(area[i] - taken[i], 1e-6 * area[i]))
            fresh.fill(False)
            continue
        weight[e], scale[e] = weigh(
            first[e], first[e + 1], log_area, low_ev, spread, which, away, log_limit, density,
            log_peak, log_free, relative,
        )  # fmt: skip
        weight[e] += prior[e]
        fresh[e] = True
    for e in range(n):
        if open_[e] and not fresh[e] and weight[e] > 0.5 * least:
            weight[e], scale[e] = weigh(
                first[e], first[e + 1], log_area, low_ev, spread, which, away, log_limit, density,
                log_peak, log_free, relative,
            )  # fmt: skip
            weight[e] += prior[e]
    return weight, scale, accepted[:found].copy(), taken


@float_kernel
def take(begin, end, scale, log_area, spread, which, area, taken):
    """Give an element what it explains of each peak: all of it where the areas agree."""
    for j in range(begin, end):
        i = which[j]
        if i < 0:
            continue
        log_expected = log_area[j] + scale
        expected = np.exp(log_expected)
        if expected <= LEAST_SHARE * area[i]:
            continue
        agrees = np.log(area[i]) - log_expected < 2.0 * spread[j]
        taken[i] += area[i] if agrees else expected
    for i in range(len(area)):
        taken[i] = min(taken[i], area[i])


@float_kernel
def best_entries(first, log_area, which):
    """Of each element the strongest line that is not in a bad channel, or its first."""
    best = first[:-1].copy()
    for e in range(len(best)):
        highest = -np.inf
        for j in range(first[e], first[e + 1]):
            if which[j] != BAD and log_area[j] > highest:
                highest, best[e] = log_area[j], j
    return best
