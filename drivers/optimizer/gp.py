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

from .best import losses
from .optimizer import Exhausted, Optimizer, Prediction, TooFew
from .problem import Point, Problem, WrongProblem
from .study import Study, is_same

DRAWN = 4096
"""Candidates where there are more points than can all be looked at."""
NEAR = 512
FITTED = 250
"""Of more that was told, so many are taken to fit the lengths."""
EIGHTH = 8
"""Of a map's places one in so many is spread evenly at first."""
NEIGHBOURS = 0.2
"""Of the mean distance between places told: how far a neighbour's value counts (w)."""
FLOOR = 0.02
"""Of the variance of everything: what is expected even where all neighbours are alike."""
ENOUGH = 2


class Gp(Optimizer):
    """Implements optimizer@1 on scikit-learn."""

    extra: ClassVar[str | None] = "optimize"

    def suggest(self, study: Study, n: int) -> list[Point]:
        from threadpoolctl import threadpool_limits

        with threadpool_limits(1):  # matrices this small gain nothing, and a busy computer loses
            return self._suggest(study, n)

    def _suggest(self, study: Study, n: int) -> list[Point]:
        candidates = free_points(study)
        places = coordinates(study.problem, candidates)
        taken = coordinates(study.problem, [*study.at, *study.waiting, *study.void])
        even = min(n, max(0, first_of(study.problem) - study.asked))
        if len(study.at) < ENOUGH:
            even = n
        chosen = spread(places, taken, even)
        if len(chosen) < min(n, len(candidates)):
            more = _edges if study.problem.maps else _improving
            chosen += more(study, places, taken, chosen, min(n, len(candidates)) - len(chosen))
        return [candidates[index] for index in chosen]

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
            middle, scale = told[:, column].mean(axis=0), _scale(told[:, column])
            process = fitted(study, known, (told[:, column] - middle) / scale)
            found, spread_ = process.predict(places, return_std=True)
            mean[:, column] = found.reshape(len(at), -1) * scale + middle
            deviation[:, column] = spread_.reshape(len(at), -1) * scale
        names = list(study.problem.goals)
        return (
            {name: mean[:, n].tolist() for n, name in enumerate(names)},
            {name: deviation[:, n].tolist() for n, name in enumerate(names)},
        )


def first_of(problem: Problem) -> int:
    """How many suggestions are spread evenly before what was told counts."""
    if problem.first is not None:
        return problem.first
    if problem.maps and problem.size is not None:
        return max(ENOUGH, problem.size // EIGHTH)
    return 2 * len(problem.variables) + 2


def free_points(study: Study) -> list[Point]:
    """What can still be suggested; raises Exhausted."""
    problem = study.problem
    points = problem.all_points()
    if points is None:
        return _drawn_points(study)
    seen = {_key(problem, point) for point in (*study.at, *study.waiting, *study.void)}
    free = [point for point in points if _key(problem, point) not in seen]
    if not free:
        raise Exhausted(f"all {len(points)} possible suggestions have been made")
    return free


def _key(problem: Problem, point: Point) -> tuple[Any, ...]:
    return tuple(
        v if isinstance(v := point[x.name], str) else round(v, 9) for x in problem.variables
    )


def _drawn_points(study: Study) -> list[Point]:
    """Random points, the same for the same study, and some around the best that was told."""
    problem = study.problem
    random = np.random.default_rng([problem.seed, study.asked, study.told])
    rows = random.random((DRAWN, len(problem.variables))).tolist()
    drawn = [problem.drawn(row) for row in rows]
    if study.at and not problem.maps:
        best = study.at[int(np.argmin(losses(study).sum(axis=1)))]
        drawn += [_moved(problem, best, random) for _ in range(NEAR)]
    drawn = [point for point in drawn if problem.keeps(point)]
    taken = [*study.at, *study.waiting, *study.void]
    free = [point for point in drawn if not any(is_same(point, one) for one in taken)]
    if not drawn:
        raise WrongProblem(f"none of {DRAWN} points drawn at random keeps the constraints")
    if not free:
        raise Exhausted("no point is left that has not been suggested")
    return free


def _moved(problem: Problem, best: Point, random: np.random.Generator) -> Point:
    point = {}
    for variable in problem.variables:
        if variable.choices:
            point[variable.name] = best[variable.name]
        else:
            width = (variable.maximum - variable.minimum) * 10 ** random.uniform(-3, -1)
            point[variable.name] = variable.stepped(
                float(best[variable.name] + random.normal(0, width))
            )
    return point


def coordinates(problem: Problem, points: list[Point]) -> np.ndarray:
    """Points as rows of numbers from 0 to 1; a map keeps its shape, choices have a column each."""
    numbers = [v for v in problem.variables if not v.choices]
    widest = max((v.maximum - v.minimum for v in numbers), default=1.0)
    columns = []
    for variable in problem.variables:
        values = [point[variable.name] for point in points]
        if variable.choices:
            columns += [[float(value == one) for value in values] for one in variable.choices]
        else:
            width = widest if problem.maps else variable.maximum - variable.minimum
            columns.append([(float(value) - variable.minimum) / width for value in values])
    return np.array(columns, float).reshape(len(columns), len(points)).T


def spread(places: np.ndarray, taken: np.ndarray, n: int) -> list[int]:
    """Indices of up to n places, each as far as possible from all before it."""
    chosen: list[int] = []
    if not n:
        return chosen
    nearest = np.full(len(places), np.inf)
    for row in taken:
        nearest = np.minimum(nearest, ((places - row) ** 2).sum(axis=1))
    while len(chosen) < min(n, len(places)):
        if np.isinf(nearest).all():
            index = int(np.argmin(((places - places.mean(axis=0)) ** 2).sum(axis=1)))
        else:
            index = int(np.argmax(nearest))
        chosen.append(index)
        nearest = np.minimum(nearest, ((places - places[index]) ** 2).sum(axis=1))
        nearest[index] = -1.0
    return chosen


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


def _scale(told: np.ndarray) -> np.ndarray:
    deviation = told.std(axis=0)
    return np.where(deviation > 0, deviation, 1.0)


def _edges(
    study: Study, places: np.ndarray, taken: np.ndarray, chosen: list[int], n: int
) -> list[int]:
    """Indices of n places where least is known of a map."""
    known = coordinates(study.problem, study.at)
    told = np.array([[row[name] for name in study.problem.goals] for row in study.values])
    told = (told - told.mean(axis=0)) / _scale(told)
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
    from scipy.stats import norm

    known = coordinates(study.problem, study.at)
    loss = losses(study)
    low, span = loss.min(axis=0), np.ptp(loss, axis=0)
    part = (loss - low) / np.where(span > 0, span, 1.0)
    waiting = np.concatenate([coordinates(study.problem, study.waiting), places[chosen]])
    free = np.ones(len(places), bool)
    free[chosen] = False
    found: list[int] = []
    kernel: Any = None
    for turn in range(n):
        random = np.random.default_rng([study.problem.seed, study.asked + turn])
        weights = random.dirichlet(np.ones(part.shape[1]))
        target = (part * weights).max(axis=1) + 0.05 * (part * weights).sum(axis=1)
        target = (target - target.mean()) / float(_scale(target))
        if kernel is None or part.shape[1] > 1:
            kernel = fitted(study, known, target).kernel_
        process = through(kernel, known, target)
        if len(waiting):
            both = np.concatenate([target, process.predict(waiting)])
            process = through(kernel, np.concatenate([known, waiting]), both)
        mean, deviation = process.predict(places, return_std=True)
        better = target.min() - mean
        gain = better * norm.cdf(better / deviation) + deviation * norm.pdf(better / deviation)
        index = int(np.argmax(np.where(free, gain, -1.0)))
        found.append(index)
        free[index] = False
        waiting = np.concatenate([waiting, places[[index]]])
    return found
