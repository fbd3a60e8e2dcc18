"""gpCAM (Noack et al., 2021): Gaussian processes with a length for each variable, also for maps.

For the best place by expected improvement, each further suggestion of a batch believing the predictions for
those before it; for maps where the variance is greatest, of processes with one shape for all goals.
"""

from typing import Any, ClassVar

import numpy as np

from .best import improvement, scale_of, weighed
from .chooser import ENOUGH, Chooser, coordinates
from .optimizer import Prediction, TooFew
from .problem import Point
from .study import Study

VARIANCE, LENGTH = (1e-3, 1e3), (1e-2, 1e1)
"""Between which the process's variance and lengths are looked for; coordinates go from 0 to 1."""
NOISE = 1e-3
TOGETHER = 128


class Gpcam(Chooser):
    """Implements optimizer@1."""

    extra: ClassVar[str | None] = "gpcam"

    def choose(self, study: Study, candidates: list[Point], chosen: list[int], n: int) -> list[int]:
        from threadpoolctl import threadpool_limits

        with threadpool_limits(1):  # matrices this small gain nothing, and a busy computer loses
            return _chosen(study, coordinates(study.problem, candidates), chosen, n)

    def predict(self, study: Study, at: list[Point]) -> tuple[Prediction, Prediction]:
        if len(study.at) < ENOUGH:
            raise TooFew(f"a model needs {ENOUGH} places told; there are {len(study.at)}")
        known, places = coordinates(study.problem, study.at), coordinates(study.problem, at)
        mean: Prediction = {}
        deviation: Prediction = {}
        for name in study.problem.goals:
            told = np.array([row[name] for row in study.values], float)
            middle, scale = told.mean(), float(scale_of(told))
            process = _trained(known, (told - middle) / scale)
            mean[name] = (_mean(process, places) * scale + middle).tolist()
            deviation[name] = (_deviation(process, places) * scale).tolist()
        return mean, deviation


def _chosen(study: Study, places: np.ndarray, chosen: list[int], n: int) -> list[int]:
    known, maps = coordinates(study.problem, study.at), study.problem.maps
    waiting = coordinates(study.problem, study.waiting)
    free = np.ones(len(places), bool)
    free[chosen] = False
    found: list[int] = []
    trained: Any = None
    for turn in range(n):
        told = _maps_told(study) if maps else weighed(study, turn)
        if trained is None or not maps:
            trained = _trained(known, told)
        pending = np.concatenate([waiting, places[[*chosen, *found]]])
        process = trained
        if len(pending):
            both = np.concatenate([told, _mean(trained, pending).reshape(-1, *told.shape[1:])])
            process = _through(np.concatenate([known, pending]), both, trained.hyperparameters)
        deviation = _deviation(process, places)
        gain = deviation if maps else improvement(told.min(), _mean(process, places), deviation)
        found.append(int(np.argmax(np.where(free, gain, -1.0))))
        free[found[-1]] = False
    return found


def _mean(process: Any, places: np.ndarray) -> np.ndarray:
    return np.asarray(process.posterior_mean(places)["m(x)"])


def _deviation(process: Any, places: np.ndarray) -> np.ndarray:
    """A part of the places at a time: gpCAM computes the covariance of all with all for it."""
    parts = np.array_split(places, -(-len(places) // TOGETHER))
    variances = [process.posterior_covariance(part, variance_only=True)["v(x)"] for part in parts]
    variance = np.concatenate([np.asarray(v).reshape(len(v), -1)[:, 0] for v in variances])
    return np.sqrt(variance.clip(1e-12))


def _maps_told(study: Study) -> np.ndarray:
    """Goals as columns, standardized: they have one shape together."""
    told = np.array([[row[name] for name in study.problem.goals] for row in study.values], float)
    return (told - told.mean(axis=0)) / scale_of(told)


def _through(known: np.ndarray, told: np.ndarray, shape: np.ndarray) -> Any:
    from gpcam import GPOptimizer  # pyright: ignore[reportMissingImports]

    return GPOptimizer(
        known, told, init_hyperparameters=shape, noise_variances=np.full(len(known), NOISE)
    )


def _trained(known: np.ndarray, told: np.ndarray) -> Any:
    bounds = np.array([VARIANCE, *[LENGTH] * known.shape[1]])
    process = _through(known, told, np.array([1.0, *[0.5] * known.shape[1]]))
    process.train(
        hyperparameter_bounds=bounds, init_hyperparameters=process.hyperparameters, method="local",
        n_restarts=1,
    )  # fmt: skip
    return process
