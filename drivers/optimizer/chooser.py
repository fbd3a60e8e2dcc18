"""Choosing among points that keep the constraints and are new: spread evenly at first, then by a method."""

from typing import Any

import numpy as np

from .best import losses
from .optimizer import Exhausted, Optimizer
from .problem import Point, Problem, WrongProblem
from .study import Study, is_same

DRAWN = 4096
"""Candidates where there are more points than can all be looked at."""
NEAR = 512
EIGHTH = 8
"""Of a map's places one in so many is spread evenly at first."""
ENOUGH = 2


class Chooser(Optimizer):
    """Implements optimizer@1 but for `choose` and, if the method has a model, `predict`."""

    def choose(self, study: Study, candidates: list[Point], chosen: list[int], n: int) -> list[int]:
        """Indices of n candidates more, beside those chosen; two places are told at least. In a thread."""
        raise NotImplementedError

    def suggest(self, study: Study, n: int) -> list[Point]:
        candidates = free_points(study)
        places = coordinates(study.problem, candidates)
        taken = coordinates(study.problem, [*study.at, *study.waiting, *study.void])
        even = min(n, max(0, first_of(study.problem) - study.asked))
        if len(study.at) < ENOUGH:
            even = n
        chosen = spread(places, taken, even)
        if len(chosen) < min(n, len(candidates)):
            more = min(n, len(candidates)) - len(chosen)
            chosen += self.choose(study, candidates, chosen, more)
        return [candidates[index] for index in chosen]


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
