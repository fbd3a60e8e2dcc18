"""Where the gain of the instrument jumps, by lines of the same elements on both sides.

An export cut at zero has no light between its lines. A smooth response goes over a jump as a slope of a
hundred nanometres, and lines near it on one side are all too bright, on the other too faint. The plot is
made straight where it is (temperature, density, opacity, amounts and response may all give way), and for
each place between two lines it is said how much likelier a jump there makes all of them.
"""

import numpy as np

from ..peaks.levenberg import factorise, normal_equations, solve
from ..plasma.boltzmann import (
    CALIBRATION,
    OPACITY_KNOWN,
    USUAL_NE_SPREAD,
    USUAL_SPREAD,
    Bend,
    Plot,
    PlotLines,
    misfit,
)
from ..plasma.growth import growth_table
from ..plasma.plot_fit import GLOBAL, depths, read_even, rows_of_table, states, thin_areas, trust
from ..plasma.response import between
from ..plasma.strengths import GRID_K, atoms
from ..spectrum.kernel import kernel, part_kernel
from ..spectrum.spectrum import FloatArray

JUMP = 1.3  # of ln(gain), one sigma beforehand
LIKELIER = 4.0  # in ln, that a jump must make the lines: some dozens of places are tried
APART_NM = 0.3
MOST = 3  # four detectors
DOUBTED = 0.5  # of a deviation: before a jump is known, lines beside it look like outliers
BESIDE = np.array([0.01, 0.05, 0.05])  # of ln T, ln n_e and opacity, for differences


def steps_by_lines(lines: PlotLines, plot: Plot, bend: Bend) -> tuple[FloatArray, FloatArray]:
    """Places of the jumps (nm) and by how much ln(gain) rises there, (s,), in the order in which they were
    found. lines: with their response; plot: fitted with `bend`, of which `stiff` may differ."""
    amount = plot.log_scale[lines.element]
    if np.isnan(amount).any():
        lines = lines.where(~np.isnan(amount))
    a, k = atoms(), len(plot.names)
    p = np.zeros(GLOBAL + k + len(bend.knots_nm))
    p[:GLOBAL] = np.log(plot.temperature_k), plot.log10_ne * np.log(10), plot.log_opacity
    p[GLOBAL : GLOBAL + k] = plot.log_scale[plot.names]
    if plot.response is not None:
        p[GLOBAL + k :] = plot.response.at(bend.knots_nm)
    found, sizes, s = _steps(
        (lines.log_area, lines.error, np.searchsorted(plot.names, lines.element), lines.vacuum_nm,
         lines.width_nm),
        (lines.rows, lines.entry, a.ion, a.log_ga, a.e_k_ev),
        plot.names, (a.log_u, GRID_K, a.limit_ev, growth_table()), p, bend.knots_nm, bend.stiff,
        np.argsort(lines.vacuum_nm),
    )  # fmt: skip
    return found[:s], sizes[:s]


@part_kernel
def _log_areas(p, rows, which, vacuum_nm, width_nm, names, tables):
    """ln of the area of each line, (n,), with parameters as of `gauss_newton`, but for the response."""
    log_u, grid_k, limit_ev, growth = tables
    n, k = len(which), len(names)
    held, ions, heat = np.empty((k, 2)), np.empty(k), np.empty((k, 2))
    thin, log_tau = np.empty(n), np.empty(n)
    states(names, log_u, grid_k, limit_ev, p, held, ions, heat)
    row_entry, row_which, row_ion, row_log_ga, row_e_k = rows
    thin_areas(row_entry, row_which, row_ion, row_log_ga, row_e_k, held, np.exp(p[0]), thin)
    depths(p, thin, which, vacuum_nm, width_nm, log_tau)
    for i in range(n):
        thin[i] += p[GLOBAL + which[i]] + read_even(growth[0], growth[1], log_tau[i])
    return thin


@kernel
def _steps(lines, table, names, tables, p, knots_nm, stiff, order):
    """The same, and how many; the plot is made straight where it is. order: of the lines along the axis."""
    log_area, error, which, vacuum_nm, width_nm = lines
    rows = rows_of_table(table, which)
    n, n_p, k, n_knots = len(log_area), len(p), len(names), len(knots_nm)
    bent = GLOBAL + k
    slope, pull, off = np.zeros((n_p + MOST, n)), np.full(n_p + MOST, 1e-9), np.zeros(n_p + MOST)
    pull[0], pull[1], pull[2] = 1 / USUAL_SPREAD**2, 1 / USUAL_NE_SPREAD**2, OPACITY_KNOWN
    model = np.zeros(n)
    for a in range(-1, GLOBAL):
        other = p.copy()
        if a >= 0:
            other[a] += BESIDE[a]
        log = _log_areas(other, rows, which, vacuum_nm, width_nm, names, tables)
        for i in range(n):
            if a < 0:
                model[i] = log[i]
            else:
                slope[a, i] = (log[i] - model[i]) / BESIDE[a]
    residual, knot, part = np.empty(n), np.zeros(n, np.int64), np.zeros(n)
    if n_knots:
        knot, part = between(knots_nm, vacuum_nm)
    for i in range(n):
        residual[i] = log_area[i] - model[i]
        slope[GLOBAL + which[i], i] = 1.0 + slope[2, i]
        if n_knots:
            b = bent + knot[i]
            slope[b, i], slope[b + 1, i] = 1.0 - part[i], part[i]
            residual[i] -= slope[b, i] * p[b] + slope[b + 1, i] * p[b + 1]
    for a in range(n_knots):
        for b in range(n_knots):
            off[bent + a] -= stiff[a, b] * p[bent + b]
    sigma, weight = np.empty(n), np.empty(n)
    for i in range(n):
        sigma[i] = np.hypot(error[i], CALIBRATION)
    more = misfit(residual, sigma, n - bent)
    for i in range(n):
        sigma[i] = np.hypot(sigma[i], more)
        weight[i] = trust(DOUBTED * residual[i] / sigma[i]) / sigma[i] ** 2
    places, after = (
        np.empty(n),
        np.empty(n, np.int64),
    )  # and the first line beyond each, in that order
    n_places = 0
    for q in range(1, n):
        before, at = vacuum_nm[order[q - 1]], vacuum_nm[order[q]]
        if at - before > APART_NM:
            places[n_places], after[n_places] = 0.5 * (before + at), q
            n_places += 1
    found, sizes = np.empty(MOST), np.empty(MOST)
    weighted, left = np.empty(n), np.empty(n)
    s = 0  # how many are found
    while True:
        m = n_p + s
        normal, lower, gradient, step = np.zeros((m, m)), np.zeros((m, m)), np.empty(m), np.zeros(m)
        normal_equations(
            step, residual, slope[:m], weight, step, pull[:m], weighted, normal, gradient
        )
        for a in range(n_knots):
            for b in range(a + 1):
                normal[bent + a, bent + b] += stiff[a, b]
        for a in range(m):
            gradient[a] += off[a]
        if not factorise(normal, lower):
            return found, sizes, 0
        solve(lower, gradient, step)
        for j in range(s):
            sizes[j] = step[n_p + j]
        if s == MOST or n_places == 0:
            break
        for i in range(n):  # left[:] = residual compiles the words of an error
            left[i] = residual[i]
        for a in range(m):
            for i in range(n):
                left[i] -= step[a] * slope[a, i]
        best, best_q = _likeliest(slope[:m], weight, left, lower, order, after[:n_places])
        if best < LIKELIER:
            break
        found[s], pull[m] = places[best_q], JUMP**-2
        for q in range(after[best_q], n):
            slope[m, order[q]] = 1.0
        s += 1
    return found, sizes, s


@part_kernel
def _likeliest(slope, weight, left, lower, order, after):
    """How much likelier, in ln, a jump at the best place makes the lines, and which place that is.

    lower: factor of the normal matrix; after: the first line beyond each place, in their order."""
    (m, n), n_places = slope.shape, len(after)
    shared, sure, rise = np.empty((m, n_places)), np.empty(n_places), np.empty(n_places)
    for a in range(m):  # sums over all lines beyond each place
        total, q = 0.0, n
        for place in range(n_places - 1, -1, -1):
            while q > after[place]:
                q -= 1
                total += slope[a, order[q]] * weight[order[q]]
            shared[a, place] = total
    known, by, q = 0.0, 0.0, n
    for place in range(n_places - 1, -1, -1):
        while q > after[place]:
            q -= 1
            known += weight[order[q]]
            by += weight[order[q]] * left[order[q]]
        sure[place], rise[place] = known, by
    for a in range(m):  # what the other parameters could do as well
        own = shared[a]
        for c in range(a):
            other, part = shared[c], lower[a, c]
            for place in range(n_places):
                own[place] -= part * other[place]
        for place in range(n_places):
            own[place] /= lower[a, a]
            sure[place] -= own[place] * own[place]
    best, best_place = -np.inf, 0
    for place in range(n_places):
        square = rise[place] * rise[place] / (sure[place] + JUMP**-2)
        likelier = 0.5 * square - 0.5 * np.log1p(JUMP**2 * sure[place])
        if likelier > best:
            best, best_place = likelier, place
    return best, best_place
