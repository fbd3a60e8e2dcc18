"""Where the gain of the instrument jumps, by lines of the same elements on both sides.

An export cut at zero has no light between its lines. A smooth response goes over a jump as a slope of a
hundred nanometres, and lines near it on one side are all too bright, on the other too faint. The plot is
made straight where it is (temperature, density, opacity, amounts and response may all give way), and for
each place between two lines it is said how much likelier a jump there makes all of them.
"""

import numpy as np

from ..plasma.boltzmann import CALIBRATION, Bend, Plot, PlotLines, misfit, slopes
from ..plasma.plot_fit import GLOBAL, trust
from ..spectrum.spectrum import FloatArray

JUMP = 1.3  # of ln(gain), one sigma beforehand
LIKELIER = 4.0  # in ln, that a jump must make the lines: some dozens of places are tried
APART_NM = 0.3
MOST = 3  # four detectors
DOUBTED = 0.5  # of a deviation: before a jump is known, lines beside it look like outliers


def steps_by_lines(lines: PlotLines, plot: Plot, bend: Bend) -> tuple[FloatArray, FloatArray]:
    """Places of the jumps (nm) and by how much ln(gain) rises there, (s,), in the order in which they were
    found. lines: with their response; plot: fitted with `bend`, of which `stiff` may differ."""
    lines = lines.where(np.isfinite(plot.log_scale[lines.element]))
    residual, slope, prior, off = slopes(lines, plot, bend)
    k = len(plot.names)
    sigma = np.hypot(lines.error, CALIBRATION)
    sigma = np.hypot(sigma, misfit(residual, sigma, len(lines) - GLOBAL - k))
    weight = trust(DOUBTED * residual / sigma) / sigma**2
    at = np.sort(lines.vacuum_nm)
    places = (0.5 * (at[1:] + at[:-1]))[np.diff(at) > APART_NM]
    found, sizes = [], np.empty(0)
    while len(places) and len(found) < MOST:
        normal = slope.T @ (weight[:, None] * slope) + prior
        left = residual - slope @ np.linalg.solve(normal, slope.T @ (weight * residual) + off)
        beyond = (lines.vacuum_nm[:, None] > places).astype(np.float64)
        shared = slope.T @ (weight[:, None] * beyond)
        sure = weight @ beyond - np.sum(shared * np.linalg.solve(normal, shared), axis=0)
        rise = (weight * left) @ beyond / (sure + JUMP**-2)
        likelier = 0.5 * rise**2 * (sure + JUMP**-2) - 0.5 * np.log1p(JUMP**2 * sure)
        best = int(np.argmax(likelier))
        if likelier[best] < LIKELIER:
            break
        found.append(places[best])
        slope = np.column_stack([slope, beyond[:, best]])
        prior = np.pad(prior, (0, 1))
        prior[-1, -1] = JUMP**-2
        off = np.append(off, 0.0)
        normal = slope.T @ (weight[:, None] * slope) + prior
        sizes = np.linalg.solve(normal, slope.T @ (weight * residual) + off)[-len(found) :]
    return np.array(found), sizes
