"""The loop of the Saha-Boltzmann plot: Gauss and Newton over ln T, ln n_e, opacity and amounts.

Parameters: ln T, ln n_e (per cm3), ln of the spectrum's opacity, then ln of each element's amount,
then ln of the instrument's response at knots.
The sums over states come from a table on an even grid of temperatures, in logarithms.
"""

import numpy as np

from ..lines.lines import BOLTZMANN_EV_PER_K, LOWERING_EV
from ..peaks.levenberg import factorise, solve
from ..spectrum.kernel import inner_kernel, kernel, part_kernel
from .growth import HC_BY_K_NM_K, PEAK_OF_LORENTZIAN
from .plasma import SAHA_PER_CM3

GLOBAL = 3  # parameters that all lines share
OUTLIER = 2.5
COOLEST_K, HOTTEST_K = 4_500.0, 19_000.0
LEAST_LN_NE, MOST_LN_NE = float(np.log(1e15)), float(np.log(3e18))
THINNEST, THICKEST = -9.0, 7.0  # of ln tau of the strongest line
LONGEST_STEP = np.array([0.25, 1.0, 1.5])  # of the first three
SETTLED = 1e-3  # steps of ln T and ln n_e too small to matter
HEAT_STEP = 0.01  # of ln T, for the slope of the sums over states


@inner_kernel
def log_sum(log_u, grid_k, kelvin):
    """ln U of one species and stage, from its table log_u (grid,)."""
    last = len(grid_k) - 1.001
    place = min(max((kelvin - grid_k[0]) / (grid_k[1] - grid_k[0]), 0.0), last)
    i = int(place)
    return log_u[i] + (place - i) * (log_u[i + 1] - log_u[i])


@inner_kernel
def states(names, log_u, grid_k, limit_ev, p, held, ions, heat):
    """For each element of `names` and stage: ln of an atom's share of a state of g = 1, E = 0.

    held (k, 2); ions (k,): share that is ionised; heat (k, 2): how held grows with ln T.
    """
    kelvin = np.exp(p[0])
    kt = BOLTZMANN_EV_PER_K * kelvin
    warmer = kelvin * (1.0 + HEAT_STEP)
    for k in range(len(names)):
        of_atoms, of_ions = log_u[names[k], 0], log_u[names[k], 1]
        u0, u1 = log_sum(of_atoms, grid_k, kelvin), log_sum(of_ions, grid_k, kelvin)
        by_heat = np.log1p(HEAT_STEP)
        growth0 = (log_sum(of_atoms, grid_k, warmer) - u0) / by_heat
        growth1 = (log_sum(of_ions, grid_k, warmer) - u1) / by_heat
        cost = (limit_ev[names[k]] - LOWERING_EV) / kt
        log_ratio = np.log(SAHA_PER_CM3) - p[1] + 1.5 * p[0] + u1 - u0 - cost
        log_neutral = -log_ratio - np.log1p(np.exp(-log_ratio))  # of 1 / (1 + ratio)
        if log_ratio < 0.0:
            log_neutral = -np.log1p(np.exp(log_ratio))
        ions[k] = 1.0 / (1.0 + np.exp(-log_ratio))
        held[k, 0], held[k, 1] = log_neutral - u0, log_neutral + log_ratio - u1
        saha = 1.5 + growth1 - growth0 + cost
        heat[k, 0] = -growth0 - ions[k] * saha
        heat[k, 1] = -growth1 + (1.0 - ions[k]) * saha


@inner_kernel
def thin_areas(row_entry, row_which, row_ion, row_log_ga, row_e_k, held, kelvin, thin):
    """Fill thin (n,) with ln of each line's thin area for one atom; rows of a line in one run."""
    inverse = -1.0 / (BOLTZMANN_EV_PER_K * kelvin)
    i, n = 0, len(row_entry)
    while i < n:
        line, begin = row_entry[i], i
        top = -np.inf
        while i < n and row_entry[i] == line:
            value = row_log_ga[i] + held[row_which[i], row_ion[i]] + inverse * row_e_k[i]
            top = max(top, value)
            i += 1
        if i == begin + 1:  # as most are
            thin[line] = top
            continue
        total = 0.0
        for j in range(begin, i):
            value = row_log_ga[j] + held[row_which[j], row_ion[j]] + inverse * row_e_k[j]
            total += np.exp(value - top)
        thin[line] = np.log(total) + top


@inner_kernel
def rows_of_table(table, which):
    """Rows as `gauss_newton` takes them. table: of the lines their rows and which line each belongs to; of
    all rows, ion, ln gA and upper level. which: element of each line."""
    row, entry, of_ions, log_ga, e_k_ev = table
    own, ion = np.empty(len(row), np.int64), np.empty(len(row), np.int64)
    log, energy = np.empty(len(row)), np.empty(len(row))
    for i in range(len(row)):
        own[i], ion[i] = which[entry[i]], of_ions[row[i]]
        log[i], energy[i] = log_ga[row[i]], e_k_ev[row[i]]
    return entry, own, ion, log, energy


@inner_kernel
def read_even(grid, values, at):
    """A value off a table on an even grid, ends level."""
    last = len(grid) - 1
    place = (at - grid[0]) / (grid[1] - grid[0])
    if place <= 0.0:
        return values[0]
    if place >= last:
        return values[last]
    i = int(place)
    return values[i] + (place - i) * (values[i + 1] - values[i])


@inner_kernel
def depths(p, thin, which, vacuum_nm, width_nm, log_tau):
    """Fill log_tau, ln of each line's optical depth; returns that of the thickest."""
    kelvin, density = np.exp(p[0]), np.exp(p[1])
    thickest = -np.inf
    for i in range(len(thin)):
        width = max(width_nm[i] * density / 1e17, 1e-4)
        nm = vacuum_nm[i]
        planck = -5.0 * np.log(nm / 500.0) - np.log(np.expm1(HC_BY_K_NM_K / (nm * kelvin)))
        depth = np.log(PEAK_OF_LORENTZIAN / width) - planck
        log_tau[i] = p[2] + thin[i] + p[GLOBAL + which[i]] + depth
        thickest = max(thickest, log_tau[i])
    return thickest


@part_kernel
def absorbed(p, thin, which, vacuum_nm, width_nm, growth, log_tau, kept, slope):
    """Fill log_tau, ln of what each line kept, and its slope; keep the opacity within bounds."""
    grid, log_f, slopes = growth
    thickest = depths(p, thin, which, vacuum_nm, width_nm, log_tau)
    beyond = min(max(thickest, THINNEST), THICKEST) - thickest
    p[2] += beyond
    for i in range(len(thin)):
        log_tau[i] += beyond
        kept[i] = read_even(grid, log_f, log_tau[i])
        slope[i] = read_even(grid, slopes, log_tau[i])


@kernel
def trust(z):
    """Weight of Geman and McClure: an outlier loses its influence."""
    return 1.0 / (1.0 + (z / OUTLIER) ** 2) ** 2


@part_kernel
def gauss_newton(
    p,
    lines,
    rows,
    names,
    tables,
    toward,
    prior,
    stiff,
    most_steps,
    thin,
    kept,
    residual,
    weight,
    normal,
):
    """Improve p in place; fill thin, kept (ln), residual and weight (n,), and the normal matrix.

    lines: ln area, its error, which element of `names`, ion, upper level (eV), vacuum nm, width nm,
    how many were seen (of the rest ln area is a limit), knot of the response before each, and which part
    of the way to the next. stiff: inverse covariance of the response beforehand, (knots, knots).
    rows: of the line table: line, which, ion, ln gA, upper level (eV). tables: ln U, its grid,
    ionisation energies, and the curve of growth.
    """
    log_area, sigma, which, ion, e_k_ev, vacuum_nm, width_nm, n_seen, knot, part = lines
    log_u, grid_k, limit_ev, growth = tables
    n, n_p, k, n_knots = len(log_area), len(p), len(names), len(stiff)
    bent = GLOBAL + k  # where the response begins
    held, ions, heat = np.empty((k, 2)), np.empty(k), np.empty((k, 2))
    slope, log_tau = np.empty(n), np.empty(n)
    gradient, lower, step = np.empty(n_p), np.zeros((n_p, n_p)), np.empty(n_p)
    row_entry, row_which, row_ion, row_log_ga, row_e_k = rows
    for turn in range(most_steps + 1):
        states(names, log_u, grid_k, limit_ev, p, held, ions, heat)
        thin_areas(row_entry, row_which, row_ion, row_log_ga, row_e_k, held, np.exp(p[0]), thin)
        absorbed(p, thin, which, vacuum_nm, width_nm, growth, log_tau, kept, slope)
        for i in range(n):
            residual[i] = log_area[i] - thin[i] - p[GLOBAL + which[i]] - kept[i]
            if n_knots:
                b = bent + knot[i]
                residual[i] -= (1.0 - part[i]) * p[b] + part[i] * p[b + 1]
            weight[i] = trust(residual[i] / sigma[i]) / sigma[i] ** 2
            if i >= n_seen and residual[i] > 0.0:
                weight[i] = 0.0
        if turn == most_steps:
            break
        kelvin = np.exp(p[0])
        kt = BOLTZMANN_EV_PER_K * kelvin
        normal.fill(0.0)
        for a in range(n_p):
            normal[a, a] = prior[a] + 1e-9
            gradient[a] = -prior[a] * (p[a] - toward[a])
        for a in range(n_knots):
            for b in range(n_knots):
                gradient[bent + a] -= stiff[a, b] * p[bent + b]
                normal[bent + a, bent + b] += stiff[a, b]
        for i in range(n):
            e, s, w = which[i], slope[i], weight[i]
            by_heat = e_k_ev[i] / kt + heat[e, ion[i]]
            by_density = ions[e] - 1.0 if ion[i] == 1 else ions[e]
            hot = HC_BY_K_NM_K / (vacuum_nm[i] * kelvin)
            # The depth grows with the thin area, and shrinks with Planck's radiance and the width.
            j0 = by_heat + s * (by_heat + hot / np.expm1(-hot))
            j1 = by_density + s * (by_density - 1.0)
            j2, j3, at = s, 1.0 + s, GLOBAL + e
            normal[0, 0] += w * j0 * j0
            normal[1, 0] += w * j1 * j0
            normal[1, 1] += w * j1 * j1
            normal[2, 0] += w * j2 * j0
            normal[2, 1] += w * j2 * j1
            normal[2, 2] += w * j2 * j2
            normal[at, 0] += w * j3 * j0
            normal[at, 1] += w * j3 * j1
            normal[at, 2] += w * j3 * j2
            normal[at, at] += w * j3 * j3
            gradient[0] += j0 * w * residual[i]
            gradient[1] += j1 * w * residual[i]
            gradient[2] += j2 * w * residual[i]
            gradient[at] += j3 * w * residual[i]
            if not n_knots:
                continue
            b, near, far = bent + knot[i], 1.0 - part[i], part[i]
            for side in range(2):
                j4 = far if side else near
                normal[b + side, 0] += w * j4 * j0
                normal[b + side, 1] += w * j4 * j1
                normal[b + side, 2] += w * j4 * j2
                normal[b + side, at] += w * j4 * j3
                normal[b + side, b + side] += w * j4 * j4
                gradient[b + side] += j4 * w * residual[i]
            normal[b + 1, b] += w * near * far
        if not factorise(normal, lower):
            break
        solve(lower, gradient, step)
        for a in range(n_p):
            if a < GLOBAL:
                step[a] = min(max(step[a], -LONGEST_STEP[a]), LONGEST_STEP[a])
            p[a] += step[a]
        largest = max(abs(step[0]), abs(step[1]))
        p[0] = min(max(p[0], np.log(COOLEST_K)), np.log(HOTTEST_K))
        p[1] = min(max(p[1], LEAST_LN_NE), MOST_LN_NE)
        if largest < SETTLED:
            most_steps = turn + 1  # to look once more at what is left over
    return inverse(normal, lower)


@part_kernel
def as_thin(log_kelvin, log_density, log_area, n_seen, which, rows, names, tables):
    """ln of each line's thin area for one atom, (n,), and of the amount of each of `names`, the mean
    over its lines that were seen; rows, tables: as of `gauss_newton`."""
    log_u, grid_k, limit_ev, _ = tables
    row_entry, row_which, row_ion, row_log_ga, row_e_k = rows
    n, k, p = len(log_area), len(names), np.empty(2)
    p[0], p[1] = log_kelvin, log_density
    held, ions, heat, thin = np.empty((k, 2)), np.empty(k), np.empty((k, 2)), np.empty(n)
    states(names, log_u, grid_k, limit_ev, p, held, ions, heat)
    thin_areas(row_entry, row_which, row_ion, row_log_ga, row_e_k, held, np.exp(p[0]), thin)
    amount, said = np.zeros(k), np.zeros(k)
    for i in range(n_seen):
        amount[which[i]] += log_area[i] - thin[i]
        said[which[i]] += 1.0
    for e in range(k):
        amount[e] /= said[e]
    return thin, amount


@kernel
def widest(values, which, k):
    """The widest range of the values of one kind; which: 0 to k - 1, (n,)."""
    low, high, most = np.full(k, np.inf), np.full(k, -np.inf), 0.0
    for i in range(len(values)):
        low[which[i]] = min(low[which[i]], values[i])
        high[which[i]] = max(high[which[i]], values[i])
        most = max(most, high[which[i]] - low[which[i]])
    return most


@inner_kernel
def inverse(normal, lower):
    """The covariance, from the normal matrix (its lower half); NaN if that is singular."""
    n = len(normal)
    unit, column = np.zeros(n), np.zeros(n)
    covariance = np.full((n, n), np.nan)
    if factorise(normal, lower):
        for a in range(n):
            unit.fill(0.0)
            unit[a] = 1.0
            solve(lower, unit, column)
            for b in range(n):
                covariance[a, b] = column[b]
    return covariance
