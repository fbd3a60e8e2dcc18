"""BayBE (Fitzner et al., 2025): its recommender chooses among candidates that keep steps and constraints.

For the best place by its default acquisition function, several goals by random weights; for maps one place
after the other where its model of the goals knows least.
"""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, ClassVar

import numpy as np

from .best import scale_of, weighed
from .chooser import ENOUGH, Chooser
from .optimizer import Prediction, TooFew
from .problem import Point, Problem, Variable
from .study import Study

MOST = 600
"""BayBE's tables grow with all candidates at once: of more than these, so many are drawn at random."""
GOAL = "loss of all goals"


class Baybe(Chooser):
    """Implements optimizer@1."""

    extra: ClassVar[str | None] = "baybe"

    def choose(self, study: Study, candidates: list[Point], chosen: list[int], n: int) -> list[int]:
        free = np.setdiff1d(np.arange(len(candidates)), chosen)
        random = np.random.default_rng([study.problem.seed, study.asked])
        some = np.sort(random.permutation(free)[: max(MOST, n)])
        pending = [*study.waiting, *(candidates[index] for index in chosen)]
        with _alone():
            table = _table(study.problem, [candidates[index] for index in some])
            model = _Model(study, table, pending)
            rows = model.doubtful(n) if study.problem.maps else model.promising(n)
        return [int(some[row]) for row in rows]

    def predict(self, study: Study, at: list[Point]) -> tuple[Prediction, Prediction]:
        if len(study.at) < ENOUGH:
            raise TooFew(f"a model needs {ENOUGH} places told; there are {len(study.at)}")
        with _alone():
            model = _Model(study, _table(study.problem, at), [])
            found = {name: model.known(study, name) for name in study.problem.goals}
        mean = {name: mean.tolist() for name, (mean, _) in found.items()}
        return mean, {name: deviation.tolist() for name, (_, deviation) in found.items()}


class _Model:
    """BayBE's view of a study, with a table of the places that may be chosen."""

    def __init__(self, study: Study, table: Any, pending: list[Point]) -> None:
        from baybe.searchspace import SearchSpace  # pyright: ignore[reportMissingImports]
        from baybe.searchspace.discrete import (  # pyright: ignore[reportMissingImports]
            SubspaceDiscrete,
        )

        self.study, self.table = study, table
        self.told = _table(study.problem, study.at)
        self.pending = _table(study.problem, pending)
        parameters = _parameters(study.problem, (table, self.told, self.pending))
        discrete = SubspaceDiscrete.from_dataframe(table, parameters)
        self.space = SearchSpace(discrete=discrete)

    def promising(self, n: int) -> list[int]:
        """Rows of the table, by its acquisition function; what is pending counts."""
        several = len(self.study.problem.goals) > 1
        if not several:
            return self._recommended(n, weighed(self.study, 0))
        rows: list[int] = []
        for turn in range(n):
            rows += self._recommended(1, weighed(self.study, turn), rows)
        return rows

    def _recommended(self, n: int, loss: np.ndarray, before: list[int] | None = None) -> list[int]:
        import pandas as pd
        from baybe.recommenders import BotorchRecommender  # pyright: ignore[reportMissingImports]

        pending = pd.concat([self.pending, self.table.iloc[before or []]], ignore_index=True)
        found = BotorchRecommender().recommend(
            n + len(before or []), self.space, _objective(), self.told.assign(**{GOAL: loss}),
            pending if len(pending) else None,
        )  # fmt: skip
        fresh = [int(row) for row in found.index if row not in (before or [])]
        return fresh[:n]

    def doubtful(self, n: int) -> list[int]:
        """Rows of the table where the goals' deviations, in units of their own spread, are greatest."""
        import pandas as pd

        rows: list[int] = []
        goals = list(self.study.problem.goals)
        told = np.array([[row[name] for name in goals] for row in self.study.values], float)
        told = (told - told.mean(axis=0)) / scale_of(told)
        for _ in range(n):
            extra = pd.concat([self.pending, self.table.iloc[rows]], ignore_index=True)
            doubt = np.zeros(len(self.table))
            for column in told.T:
                believed = self._posterior(self.told, column, extra)[0] if len(extra) else []
                places = pd.concat([self.told, extra], ignore_index=True)
                both = np.concatenate([column, believed])
                doubt += self._posterior(places, both, self.table)[1] ** 2
            doubt[rows] = -1.0
            rows.append(int(np.argmax(doubt)))
        return rows

    def known(self, study: Study, goal: str) -> tuple[np.ndarray, np.ndarray]:
        """Mean and deviation of a goal at each row of the table."""
        told = np.array([row[goal] for row in study.values], float)
        return self._posterior(self.told, told, self.table)

    def _posterior(self, places: Any, told: np.ndarray, at: Any) -> tuple[np.ndarray, np.ndarray]:
        from baybe.surrogates import (  # pyright: ignore[reportMissingImports]
            GaussianProcessSurrogate,
        )

        process = GaussianProcessSurrogate()
        process.fit(self.space, _objective(), places.assign(**{GOAL: told}))
        stats = process.posterior_stats(at)
        return stats[f"{GOAL}_mean"].to_numpy(float), stats[f"{GOAL}_std"].to_numpy(float)


@contextmanager
def _alone() -> Iterator[None]:
    """In one thread, since matrices this small gain nothing by more; with the same luck each time.

    What torch, pandas and BayBE warn of is for those who write them.
    """
    import torch  # pyright: ignore[reportMissingImports]

    torch.set_num_threads(1)
    torch.manual_seed(1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def _objective() -> Any:
    from baybe.targets import NumericalTarget  # pyright: ignore[reportMissingImports]

    return NumericalTarget(GOAL, minimize=True).to_objective()


def _table(problem: Problem, points: list[Point]) -> Any:
    import pandas as pd

    return pd.DataFrame(
        {
            v.name: [str(p[v.name]) if v.choices else float(p[v.name]) for p in points]
            for v in _varied(problem)
        }
    )


def _varied(problem: Problem) -> list[Variable]:
    """Without choices of one, which BayBE does not take."""
    return [v for v in problem.variables if len(v.choices) != 1]


def _parameters(problem: Problem, tables: tuple[Any, ...]) -> list[Any]:
    from baybe.parameters import (  # pyright: ignore[reportMissingImports]
        CategoricalParameter,
        NumericalDiscreteParameter,
    )

    made: list[Any] = []
    for variable in _varied(problem):
        if variable.choices:
            values = [str(choice) for choice in variable.choices]
            made.append(CategoricalParameter(variable.name, values, encoding="OHE"))
        else:
            ends = {variable.minimum, variable.maximum}
            found = ends.union(*(table[variable.name] for table in tables))
            made.append(NumericalDiscreteParameter(variable.name, sorted(found), tolerance=0))
    return made
