"""Fit overlapping Voigt profiles on a straight line by Levenberg-Marquardt, analytic derivatives.

Parameters: area, centre, sigma, gamma of each peak, then height and tilt of the line. Bounds are
kept by clipping the step; a parameter that is at its bound and pushes outwards rests for a step.
(More, in Numerical Analysis, Lecture Notes in Mathematics 630 (1978), for the damping by scale.)
"""

import numpy as np

from ..spectrum.kernel import inner_kernel, kernel, sum_kernel
from .faddeeva import ONE_BY_ROOT_PI, faddeeva_row

PER_PEAK = 4  # area, centre, sigma, gamma
PER_LINE = 2  # height, tilt
ROOT_2 = float(np.sqrt(2.0))
ROOT_2_PI = float(np.sqrt(2.0 * np.pi))
MAX_STEPS = 60
FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-3, 1e-9, 1e9
EASE, PRESS = 0.15, 6.0  # what damping is multiplied by after a good and after a bad step
ENOUGH = 1e-2  # a gain in chi2 (in units of noise squared) too small to matter, and
ENOUGH_RELATIVE = 1e-6  # the same as a part of chi2
SURELY_ENOUGH = 1e-2  # a gain that is expected of a step and not looked at


@kernel
def evaluate(p, x, model, jacobian):
    """Fill model (m,) and jacobian (len(p), m) at the wavelengths x (m,), in nm from the middle.

    One loop for each row: a compiler that must not assume that two rows are apart in memory checks
    that for a few of them only, and otherwise takes one channel at a time.
    """
    m, n_peaks = len(x), (len(p) - PER_LINE) // PER_PEAK
    line = PER_PEAK * n_peaks
    height, tilt = p[line], p[line + 1]
    level, slope = jacobian[line], jacobian[line + 1]
    for i in range(m):
        model[i] = height + tilt * x[i]
        level[i] = 1.0
    for i in range(m):
        slope[i] = x[i]
    for k in range(n_peaks):
        at = PER_PEAK * k
        area, centre, sigma, gamma = p[at], p[at + 1], p[at + 2], p[at + 3]
        scale = 1.0 / (sigma * ROOT_2)
        norm = 1.0 / (sigma * ROOT_2_PI)
        height = gamma * scale
        by_area, by_place, by_width = area * norm, 2.0 * area * norm * scale, area * norm / sigma
        own = jacobian[at : at + PER_PEAK]
        profile, place, width, foot = own[0], own[1], own[2], own[3]
        # Until they are slopes, these two are the real and the imaginary part of w.
        faddeeva_row(x, centre, scale, height, profile, foot)
        for i in range(m):
            model[i] += by_area * profile[i]
        # dw/dz = -2 z w + 2i / sqrt(pi); the width's slope is a sum of the others'
        for i in range(m):
            away = (x[i] - centre) * scale
            place[i] = by_place * (away * profile[i] - height * foot[i])
        for i in range(m):
            away = (x[i] - centre) * scale
            foot[i] = by_place * (away * foot[i] + height * profile[i] - ONE_BY_ROOT_PI)
        for i in range(m):
            away = (x[i] - centre) * scale
            width[i] = ROOT_2 * (away * place[i] - height * foot[i])
        for i in range(m):
            width[i] -= by_width * profile[i]
        for i in range(m):
            profile[i] *= norm


@sum_kernel
def dot(a, b):
    """Sum of products."""
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@inner_kernel
def normal_equations(p, residual, jacobian, weight, toward, pull, weighted, hessian, gradient):
    """Fill hessian = J W J^T + pull (its lower half) and gradient = J W r - pull (p - toward).

    weighted: for one row of J W.
    """
    n, m = jacobian.shape
    for a in range(n):
        own = jacobian[a]
        for i in range(m):
            weighted[i] = own[i] * weight[i]
        gradient[a] = dot(weighted, residual) - pull[a] * (p[a] - toward[a])
        for b in range(a + 1):
            hessian[a, b] = dot(weighted, jacobian[b])
        hessian[a, a] += pull[a]


@sum_kernel
def factorise(matrix, lower):
    """Cholesky factor into `lower`; False when the matrix is not positive definite.

    Only the lower halves of both are used.
    """
    n = len(matrix)
    for a in range(n):
        for b in range(a + 1):
            total = matrix[a, b]
            for c in range(b):
                total -= lower[a, c] * lower[b, c]
            if a == b:
                if not total > 0.0:
                    return False
                lower[a, a] = np.sqrt(total)
            else:
                lower[a, b] = total / lower[b, b]
    return True


@inner_kernel
def solve(lower, right, solution):
    """Solve L L^T solution = right."""
    n = len(right)
    for a in range(n):
        total = right[a]
        for c in range(a):
            total -= lower[a, c] * solution[c]
        solution[a] = total / lower[a, a]
    for a in range(n - 1, -1, -1):
        total = solution[a]
        for c in range(a + 1, n):
            total -= lower[c, a] * solution[c]
        solution[a] = total / lower[a, a]


@inner_kernel
def rest_at_bounds(p, lowest, highest, hessian, gradient):
    """Remove parameters that are at a bound and would cross it from the equations."""
    for a in range(len(p)):
        out = (p[a] <= lowest[a] and gradient[a] <= 0.0) or (
            p[a] >= highest[a] and gradient[a] >= 0.0
        )
        if out or not hessian[a, a] > 0.0:
            for b in range(a):
                hessian[a, b] = 0.0
            for b in range(a + 1, len(p)):
                hessian[b, a] = 0.0
            hessian[a, a] = 1.0
            gradient[a] = 0.0


@sum_kernel
def cost(y, model, weight, p, toward, pull, residual):
    """chi2 with what the pulls cost; residual (m,) is filled."""
    for i in range(len(y)):
        residual[i] = y[i] - model[i]
    total = 0.0
    for i in range(len(y)):
        total += residual[i] * residual[i] * weight[i]
    for a in range(len(p)):
        total += pull[a] * (p[a] - toward[a]) ** 2
    return total


@kernel
def fit(p, x, y, weight, toward, pull, lowest, highest):
    """Improve p in place; return chi2, the final hessian, and whether it converged.

    x: nm from the middle of the window; y: counts; weight: 1 / noise^2; all of shape (m,).
    p, toward, pull, lowest, highest: shape (4 peaks + 2,). pull: 1 / s^2 for a parameter that is
    known beforehand to be `toward` to within s, else 0; chi2 counts what it costs.
    """
    n, m = len(p), len(x)
    model, jacobian = np.empty(m), np.empty((n, m))
    hessian, gradient = np.empty((n, n)), np.empty(n)
    damped, lower = np.empty((n, n)), np.zeros((n, n))
    step, trial = np.empty(n), np.empty(n)
    evaluate(p, x, model, jacobian)
    residual, weighted = np.empty(m), np.empty(m)
    chi2 = cost(y, model, weight, p, toward, pull, residual)
    normal_equations(p, residual, jacobian, weight, toward, pull, weighted, hessian, gradient)
    rest_at_bounds(p, lowest, highest, hessian, gradient)
    damping = FIRST_DAMPING
    for _ in range(MAX_STEPS):
        for a in range(n):
            for b in range(a + 1):
                damped[a, b] = hessian[a, b]
            damped[a, a] *= 1.0 + damping
        if factorise(damped, lower):
            solve(lower, gradient, step)
            expected = 0.0  # gain, by the model of normal equations
            for a in range(n):
                trial[a] = min(max(p[a] + step[a], lowest[a]), highest[a])
                expected += step[a] * (gradient[a] + damping * hessian[a, a] * step[a])
            if damping <= FIRST_DAMPING and expected <= SURELY_ENOUGH:
                for a in range(n):
                    p[a] = trial[a]
                return chi2 - max(expected, 0.0), hessian, True
            evaluate(trial, x, model, jacobian)
            trial_chi2 = cost(y, model, weight, trial, toward, pull, residual)
            if trial_chi2 <= chi2:
                gain = chi2 - trial_chi2
                for a in range(n):
                    p[a] = trial[a]
                chi2 = trial_chi2
                normal_equations(
                    p, residual, jacobian, weight, toward, pull, weighted, hessian, gradient
                )
                rest_at_bounds(p, lowest, highest, hessian, gradient)
                if gain <= ENOUGH + ENOUGH_RELATIVE * chi2:
                    return chi2, hessian, True
                damping = max(damping * EASE, LEAST_DAMPING)
                continue
        damping *= PRESS
        if damping > MOST_DAMPING:
            return chi2, hessian, True  # no step of any length gains anything
    return chi2, hessian, False
