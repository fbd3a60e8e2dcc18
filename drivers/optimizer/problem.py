"""What may be varied and what is wanted, as a protocol says it."""

import itertools
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from simpleeval import InvalidExpression, SimpleEval

Point = dict[str, Any]
FEW = 20_000
"""So many different points, at most, are all looked at."""


class WrongProblem(ValueError):
    """What was defined makes no sense; the text says why."""


@dataclass(frozen=True, slots=True)
class Variable:
    """A number between two bounds, in steps if `step` is not 0; or one of `choices`."""

    name: str
    minimum: float = 0.0
    maximum: float = 1.0
    step: float = 0.0
    choices: tuple[str | float, ...] = ()

    def values(self) -> list[Any] | None:
        """All that it can be; None if it can be any number."""
        if self.choices:
            return list(self.choices)
        if not self.step:
            return None
        count = math.floor((self.maximum - self.minimum) / self.step + 1e-9) + 1
        return [self.stepped(self.minimum + n * self.step) for n in range(count)]

    def stepped(self, value: float) -> float:
        """The nearest value that it can be."""
        value = min(max(value, self.minimum), self.maximum)
        if not self.step:
            return value
        count = math.floor((self.maximum - self.minimum) / self.step + 1e-9)
        n = min(round((value - self.minimum) / self.step), count)
        return round(self.minimum + n * self.step, 10)

    def takes(self, value: Any) -> bool:
        """Whether it can be this, but for rounding."""
        if self.choices:
            return value in self.choices
        return abs(self.stepped(value) - value) <= 1e-9 * max(1.0, abs(value))

    def drawn(self, part: float) -> Any:
        """Its value for a number from 0 to 1."""
        if self.choices:
            return self.choices[min(int(part * len(self.choices)), len(self.choices) - 1)]
        if self.step:
            values = self.values() or [self.minimum]
            return values[min(int(part * len(values)), len(values) - 1)]
        return self.minimum + part * (self.maximum - self.minimum)


@dataclass(frozen=True, slots=True)
class Problem:
    """Variables, goals (name -> minimize, maximize or map) and constraints of one study."""

    variables: tuple[Variable, ...]
    goals: Mapping[str, str]
    constraints: tuple[str, ...] = ()
    first: int | None = None
    seed: int = 1

    @property
    def maps(self) -> bool:
        """Whether it is to be known everywhere, rather than the best to be found."""
        return "map" in self.goals.values()

    @property
    def size(self) -> int | None:
        """How many points there are without constraints; None for any number."""
        each = [variable.values() for variable in self.variables]
        return None if None in each else math.prod(len(values or ()) for values in each)

    def keeps(self, point: Point) -> bool:
        """Whether a point keeps the constraints; raises WrongProblem."""
        return all(_holds(text, point) for text in self.constraints)

    def all_points(self) -> list[Point] | None:
        """Every point that keeps the constraints; None if they are too many."""
        if self.size is None or self.size > FEW:
            return None
        names = [variable.name for variable in self.variables]
        rows = itertools.product(*(variable.values() or () for variable in self.variables))
        return [point for row in rows if self.keeps(point := dict(zip(names, row, strict=True)))]

    def drawn(self, parts: Iterable[float]) -> Point:
        """The point for numbers from 0 to 1, one for each variable."""
        return {v.name: v.drawn(part) for v, part in zip(self.variables, parts, strict=True)}


def read_problem(said: Mapping[str, Any]) -> Problem:
    """A problem from the parameters of `define`; raises WrongProblem."""
    variables = tuple(_variable(name, one) for name, one in said["space"].items())
    goals = dict(said["goals"])
    if len({wanted == "map" for wanted in goals.values()}) > 1:
        raise WrongProblem("either all goals are maps or none: knowing all is no way to the best")
    if both := sorted(goals.keys() & said["space"].keys()):
        raise WrongProblem(f"{', '.join(both)} cannot be varied and be a goal at the same time")
    first, seed = said.get("first"), said.get("seed", 1)
    problem = Problem(variables, goals, tuple(said.get("constraints") or ()), first, seed)
    problem.keeps(problem.drawn(0.5 for _ in variables))  # can each constraint be computed?
    if problem.all_points() == []:
        raise WrongProblem("nothing keeps all constraints")
    return problem


def _variable(name: str, said: Mapping[str, Any]) -> Variable:
    if choices := said.get("choices"):
        if set(said) - {"choices"}:
            raise WrongProblem(f"{name}: choices have no bounds and no step")
        if len(set(choices)) < len(choices):
            raise WrongProblem(f"{name}: a choice comes twice")
        return Variable(name, choices=tuple(choices))
    if "minimum" not in said or "maximum" not in said:
        raise WrongProblem(f"{name} needs a minimum and a maximum, or choices")
    low, high, step = float(said["minimum"]), float(said["maximum"]), float(said.get("step", 0))
    if low >= high:
        raise WrongProblem(f"{name}: the minimum {low:g} is not below the maximum {high:g}")
    if step > high - low:
        raise WrongProblem(f"{name}: a step of {step:g} is wider than {low:g} to {high:g}")
    return Variable(name, low, high, step)


@cache
def _parsed(text: str) -> Any:
    return SimpleEval.parse(text)


def _holds(text: str, point: Point) -> bool:
    try:
        found = SimpleEval(names=point, functions={}).eval(text, previously_parsed=_parsed(text))
    except (InvalidExpression, SyntaxError, TypeError, ValueError, ArithmeticError) as fault:
        raise WrongProblem(
            f"the constraint {text!r} cannot be computed from {', '.join(point)}: {fault}"
        ) from fault
    if not isinstance(found, bool):
        raise WrongProblem(
            f"the constraint {text!r} gives {found}, which is neither true nor false"
        )
    return found
