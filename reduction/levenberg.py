"""Fit overlapping Voigt profiles on a straight line by Levenberg-Marquardt, slopes analytic.

Parameters: area, centre, sigma, gamma of each peak, then height and tilt of the line. Bounds are
kept by clipping the step; a parameter that is at its bound and pushes outwards rests for a step.
(More, in Numerical Analysis, Lecture Notes in Mathematics 630 (1978), for the damping by scale.)
"""

import numpy as np

from .faddeeva import faddeeva, faddeeva_slope
from .kernel import float_kernel

PER_PEAK = 4  # area, centre, sigma, gamma
PER_LINE = 2  # height, tilt
ROOT_2 = float(np.sqrt(2.0))
ROOT_2_PI = float(np.sqrt(2.0 * np.pi))
MAX_STEPS = 60
FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-3, 1e-9, 1e9
EASE, PRESS = 0.15, 6.0  # what damping is multiplied by after a good and after a bad step
ENOUGH = 1e-2  # a gain in chi2 (in units of noise squared) too small to matter, and
ENOUGH_RELATIVE = 1e-6  # the same as a part of chi2


@float_kernel
def evaluate(p, x, model, jacobian):
    """Fill model (m,) and jacobian (len(p), m) at the wavelengths x (m,), in nm from the middle."""
    n_peaks = (len(p) - PER_LINE) // PER_PEAK
    line = PER_PEAK * n_peaks
    for i in range(len(x)):
        model[i] = p[line] + p[line + 1] * x[i]
        jacobian[line, i] = 1.0
        jacobian[line + 1, i] = x[i]
    for k in range(n_peaks):
        at = PER_PEAK * k
        area, centre, sigma, gamma = p[at], p[at + 1], p[at + 2], p[at + 3]
        scale = 1.0 / (sigma * ROOT_2)
        norm = 1.0 / (sigma * ROOT_2_PI)
        for i in range(len(x)):
            z = complex((x[i] - centre) * scale, gamma * scale)
            w = faddeeva(z)
            slope = faddeeva_slope(z, w)
            profile = w.real * norm
            model[i] += area * profile
            jacobian[at, i] = profile
            jacobian[at + 1, i] = -area * norm * scale * slope.real
            by_sigma = -(w.real + z.real * slope.real - z.imag * slope.imag) / sigma
            jacobian[at + 2, i] = area * norm * by_sigma
            jacobian[at + 3, i] = -area * norm * scale * slope.imag


@float_kernel
def normal_equations(p, residual, jacobian, weight, toward, pull, hessian, gradient):
    """Fill hessian = J W J^T + pull and gradient = J W r - pull (p - toward)."""
    n, m = jacobian.shape
    weighted = np.empty(m)
    for a in range(n):
        total = 0.0
        for i in range(m):
            weighted[i] = jacobian[a, i] * weight[i]
            total += weighted[i] * residual[i]
        gradient[a] = total
        for b in range(a, n):
            total = 0.0
            for i in range(m):
                total += weighted[i] * jacobian[b, i]
            hessian[a, b] = total
            hessian[b, a] = total
        hessian[a, a] += pull[a]
        gradient[a] -= pull[a] * (p[a] - toward[a])


@float_kernel
def factorise(matrix, lower):
    """Cholesky factor into `lower`; False when the matrix is not positive definite."""
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


@float_kernel
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


@float_kernel
def rest_at_bounds(p, lowest, highest, hessian, gradient):
    """Take out of the equations what is at its bound and would cross it."""
    for a in range(len(p)):
        out = (p[a] <= lowest[a] and gradient[a] <= 0.0) or (
            p[a] >= highest[a] and gradient[a] >= 0.0
        )
        if out or not hessian[a, a] > 0.0:
            hessian[a, :] = 0.0
            hessian[:, a] = 0.0
            hessian[a, a] = 1.0
            gradient[a] = 0.0


@float_kernel
def fit(p, x, y, weight, toward, pull, lowest, highest):
    """Improve p in place; give back chi2, the hessian at the end, and whether it settled.

    x: nm from the middle of the window; y: counts; weight: 1 / noise^2; all of shape (m,).
    p, toward, pull, lowest, highest: shape (4 peaks + 2,). pull: 1 / s^2 for a parameter that is
    known beforehand to be `toward` to within s, else 0; chi2 counts what it costs.
    """
    n, m = len(p), len(x)
    model, jacobian = np.empty(m), np.empty((n, m))
    hessian, gradient = np.empty((n, n)), np.empty(n)
    damped, lower, step = np.empty((n, n)), np.zeros((n, n)), np.empty(n)
    evaluate(p, x, model, jacobian)
    residual = y - model
    chi2 = np.sum(residual * residual * weight) + np.sum(pull * (p - toward) ** 2)
    normal_equations(p, residual, jacobian, weight, toward, pull, hessian, gradient)
    rest_at_bounds(p, lowest, highest, hessian, gradient)
    damping = FIRST_DAMPING
    for _ in range(MAX_STEPS):
        damped[:] = hessian
        for a in range(n):
            damped[a, a] *= 1.0 + damping
        if factorise(damped, lower):
            solve(lower, gradient, step)
            trial = np.minimum(np.maximum(p + step, lowest), highest)
            evaluate(trial, x, model, jacobian)
            residual = y - model
            trial_chi2 = np.sum(residual * residual * weight) + np.sum(pull * (trial - toward) ** 2)
            if trial_chi2 <= chi2:
                gain = chi2 - trial_chi2
                p[:] = trial
                chi2 = trial_chi2
                normal_equations(p, residual, jacobian, weight, toward, pull, hessian, gradient)
                rest_at_bounds(p, lowest, highest, hessian, gradient)
                if gain <= ENOUGH + ENOUGH_RELATIVE * chi2:
                    return chi2, hessian, True
                damping = max(damping * EASE, LEAST_DAMPING)
                continue
        damping *= PRESS
        if damping > MOST_DAMPING:
            return chi2, hessian, True  # no step of any length gains anything
    return chi2, hessian, False
