"""The best that was told: one place, or a front of them where there are several goals."""

from typing import Any

import numpy as np

from .study import Study


def losses(study: Study) -> np.ndarray:
    """What was told, one row each and one column a goal; smaller is better."""
    goals = study.problem.goals
    signs = np.array([-1.0 if wanted == "maximize" else 1.0 for wanted in goals.values()])
    return np.array([[row[name] for name in goals] for row in study.values], float) * signs


def best_of(study: Study) -> dict[str, Any]:
    """`at`, `values` and the `front`: nothing that was told is better than these in every goal."""
    loss = losses(study)
    no_worse = (loss[None] <= loss[:, None]).all(axis=2)
    better = (loss[None] < loss[:, None]).any(axis=2)
    front = np.flatnonzero(np.sum(no_worse & better, axis=1) == 0)
    low, span = loss.min(axis=0), np.ptp(loss, axis=0)
    away = ((loss[front] - low) / np.where(span > 0, span, 1.0)) ** 2
    nearest = int(front[np.argmin(away.sum(axis=1))])
    rows = [{"at": study.at[n], "values": study.values[n]} for n in front]
    return {"at": study.at[nearest], "values": study.values[nearest], "front": rows}


def weighed(study: Study, turn: int) -> np.ndarray:
    """What was told as one loss, standardized: several goals by random weights (Knowles, 2006)."""
    loss = losses(study)
    low, span = loss.min(axis=0), np.ptp(loss, axis=0)
    part = (loss - low) / np.where(span > 0, span, 1.0)
    random = np.random.default_rng([study.problem.seed, study.asked + turn])
    weights = random.dirichlet(np.ones(part.shape[1]))
    one = (part * weights).max(axis=1) + 0.05 * (part * weights).sum(axis=1)
    return (one - one.mean()) / float(scale_of(one))


def scale_of(told: np.ndarray) -> np.ndarray:
    """Standard deviations, and 1 where everything is alike."""
    deviation = told.std(axis=0)
    return np.where(deviation > 0, deviation, 1.0)


def improvement(lowest: float, mean: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Expected improvement of the lowest loss (Jones et al., 1998)."""
    from scipy.stats import norm

    better = lowest - mean
    return better * norm.cdf(better / deviation) + deviation * norm.pdf(better / deviation)
