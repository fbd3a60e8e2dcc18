"""Gaussian processes: for the best place by expected improvement, for maps where two grains may meet.

For maps a place is scored by s^2(x) v(x). s^2 is the variance of a process with the covariance
exp(-r / l) (Matern 1/2: what lies beyond a grain's edge is independent of it), given where was
measured; v is the variance of what was told around x, weighted with exp(-r / w). Inside a grain all
neighbours are alike and v is small; at an edge they differ. The length l is fitted.
For the best place: Matern 5/2 with a length for each variable, Jones et al. (1998); several goals by
random weights, Knowles (2006); each further suggestion of a batch believes the earlier ones' predictions.
"""

import warnings
from typing import Any, ClassVar

import numpy as np

from .best import improvement, scale_of, weighed
from .chooser import ENOUGH, Chooser, coordinates
from .optimizer import Prediction, TooFew
from .problem import Point
from .study import Study

FITTED = 250
"""Of more that was told, so many are taken to fit the lengths."""
NEIGHBOURS = 0.2
"""Of the mean distance between places told: how far a neighbour's value counts (w)."""
FLOOR = 0.02
"""Of the variance of everything: what is expected even where all neighbours are alike."""


class Gp(Chooser):
    """Implements optimizer@1 on scikit-learn."""

    extra: ClassVar[str | None] = "optimize"

    def choose(self, study: Study, candidates: list[Point], chosen: list[int], n: int) -> list[int]:
        from threadpoolctl import threadpool_limits

        more = _edges if study.problem.maps else _improving
        taken = coordinates(study.problem, [*study.at, *study.waiting, *study.void])
        with threadpool_limits(1):  # matrices this small gain nothing, and a busy computer loses
            return more(study, coordinates(study.problem, candidates), taken, chosen, n)

    def predict(self, study: Study, at: list[Point]) -> tuple[Prediction, Prediction]:
        if len(study.at) < ENOUGH:
            raise TooFew(f"a model needs {ENOUGH} places told; there are {len(study.at)}")
        from threadpoolctl import threadpool_limits

        with threadpool_limits(1):
            return self._predict(study, at)

    def _predict(self, study: Study, at: list[Point]) -> tuple[Prediction, Prediction]:
        known, places = coordinates(study.problem, study.at), coordinates(study.problem, at)
        told = np.array([[row[name] for name in study.problem.goals] for row in study.values])
        together = study.problem.maps
        columns = [list(range(told.shape[1]))] if together else [[n] for n in range(told.shape[1])]
        mean, deviation = np.empty((len(at), told.shape[1])), np.empty((len(at), told.shape[1]))
        for column in columns:
            middle, scale = told[:, column].mean(axis=0), scale_of(told[:, column])
            process = fitted(study, known, (told[:, column] - middle) / scale)
            found, spread_ = process.predict(places, return_std=True)
            mean[:, column] = found.reshape(len(at), -1) * scale + middle
            deviation[:, column] = spread_.reshape(len(at), -1) * scale
        names = list(study.problem.goals)
        return (
            {name: mean[:, n].tolist() for n, name in enumerate(names)},
            {name: deviation[:, n].tolist() for n, name in enumerate(names)},
        )


def fitted(study: Study, known: np.ndarray, told: np.ndarray) -> Any:
    """A process through what was told (standardized), its lengths fitted."""
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import Matern, WhiteKernel

    maps = study.problem.maps
    lengths: Any = 0.2 if maps else np.full(known.shape[1], 0.5)
    shape = Matern(lengths, (0.01, 10.0), nu=0.5 if maps else 2.5)
    kernel = shape + WhiteKernel(0.01, (1e-6, 1.0))
    random = np.random.default_rng([study.problem.seed, len(known)])
    some = random.permutation(len(known))[:FITTED]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # no noise at all: the end of its range
        lengths_found = GaussianProcessRegressor(kernel).fit(known[some], told[some]).kernel_
    return through(lengths_found, known, told)


def through(kernel: Any, known: np.ndarray, told: np.ndarray) -> Any:
    """A process with these lengths through what was told."""
    from sklearn.gaussian_process import GaussianProcessRegressor

    as_it_is: Any = None
    return GaussianProcessRegressor(kernel, optimizer=as_it_is).fit(known, told)


def _edges(
    study: Study, places: np.ndarray, taken: np.ndarray, chosen: list[int], n: int
) -> list[int]:
    """Indices of n places where least is known of a map."""
    known = coordinates(study.problem, study.at)
    told = np.array([[row[name] for name in study.problem.goals] for row in study.values])
    told = (told - told.mean(axis=0)) / scale_of(told)
    kernel = fitted(study, known, told).kernel_
    noise = max(float(kernel.k2.noise_level), 1e-3)
    volume = np.prod(np.ptp(places, axis=0).clip(1e-3))
    near = NEIGHBOURS * (volume / len(known)) ** (1 / places.shape[1])
    apart = np.sqrt(((places[:, None] - known[None]) ** 2).sum(axis=2))
    weight = np.exp(-(apart - apart.min(axis=1, keepdims=True)) / near)
    weight /= weight.sum(axis=1, keepdims=True)
    differ = (weight @ told**2 - (weight @ told) ** 2).clip(0).sum(axis=1) + FLOOR * told.shape[1]
    seen = np.concatenate([taken, places[chosen]])
    across = kernel.k1(places, seen)
    inverse = np.linalg.inv(kernel.k1(seen) + noise * np.eye(len(seen)))
    variance = 1 - ((across @ inverse) * across).sum(axis=1)
    rows = [across @ inverse]
    free = np.ones(len(places), bool)
    free[chosen] = False
    found: list[int] = []
    steps: list[np.ndarray] = []
    for _ in range(n):
        index = int(np.argmax(np.where(free, differ * variance, -1.0)))
        found.append(index)
        free[index] = False
        covariance = kernel.k1(places, places[[index]])[:, 0] - rows[0] @ across[index]
        for step in steps:
            covariance = covariance - step * step[index]
        step = covariance / np.sqrt(variance[index] + noise)
        steps.append(step)
        variance = (variance - step**2).clip(1e-12)
    return found


def _improving(
    study: Study, places: np.ndarray, taken: np.ndarray, chosen: list[int], n: int
) -> list[int]:
    """Indices of n places with the greatest expected improvement."""
    known = coordinates(study.problem, study.at)
    waiting = np.concatenate([coordinates(study.problem, study.waiting), places[chosen]])
    free = np.ones(len(places), bool)
    free[chosen] = False
    found: list[int] = []
    kernel: Any = None
    for turn in range(n):
        target = weighed(study, turn)
        if kernel is None or len(study.problem.goals) > 1:
            kernel = fitted(study, known, target).kernel_
        process = through(kernel, known, target)
        if len(waiting):
            both = np.concatenate([target, process.predict(waiting)])
            process = through(kernel, np.concatenate([known, waiting]), both)
        mean, deviation = process.predict(places, return_std=True)
        gain = improvement(target.min(), mean, deviation)
        index = int(np.argmax(np.where(free, gain, -1.0)))
        found.append(index)
        free[index] = False
        waiting = np.concatenate([waiting, places[[index]]])
    return found
