"""Optuna's tree-structured Parzen estimator (Bergstra et al., 2011): many choices, many trials."""

from typing import Any, ClassVar

from .optimizer import Exhausted, Optimizer
from .problem import Point, Variable, WrongProblem
from .study import Study, is_same

DRAWS = 500
"""So many draws, at most, for one suggestion that keeps the constraints and is new."""


class Optuna(Optimizer):
    """Implements optimizer@1 but for maps and `model`."""

    extra: ClassVar[str | None] = "optuna"

    def suggest(self, study: Study, n: int) -> list[Point]:
        import optuna  # pyright: ignore[reportMissingImports]
        from optuna.trial import TrialState, create_trial  # pyright: ignore[reportMissingImports]

        problem = study.problem
        if problem.maps:
            raise WrongProblem("optuna looks for the best; for maps take the driver gp")
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        sampler = optuna.samplers.TPESampler(
            seed=(problem.seed * 1_000_003 + study.asked) % 2**32,
            n_startup_trials=problem.first or 10,
        )
        directions = list(problem.goals.values())
        known = optuna.create_study(directions=directions, sampler=sampler)
        ranges = {v.name: _range(v) for v in problem.variables}
        for at, values in zip(study.at, study.values, strict=True):
            if all(variable.takes(at[variable.name]) for variable in problem.variables):
                results = [values[name] for name in problem.goals]
                known.add_trial(create_trial(params=at, distributions=ranges, values=results))
        taken = [*study.at, *study.waiting, *study.void]
        found: list[Point] = []
        for _ in range(n * DRAWS):
            trial = known.ask(ranges)
            point = {v.name: _plain(v, trial.params[v.name]) for v in problem.variables}
            known.tell(trial, state=TrialState.FAIL)
            if problem.keeps(point) and not any(is_same(point, one) for one in [*taken, *found]):
                found.append(point)
                if len(found) == n:
                    break
        if not found:
            raise Exhausted(f"{n * DRAWS} draws gave nothing new that keeps the constraints")
        return found


def _range(variable: Variable) -> Any:
    from optuna import distributions  # pyright: ignore[reportMissingImports]

    if variable.choices:
        return distributions.CategoricalDistribution(variable.choices)
    highest = (variable.values() or [variable.maximum])[-1]
    return distributions.FloatDistribution(variable.minimum, highest, step=variable.step or None)


def _plain(variable: Variable, value: Any) -> Any:
    return value if variable.choices else variable.stepped(float(value))
