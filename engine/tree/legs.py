"""How long the actions of one iteration will keep which devices, as far as that is known before it begins.

Known are the durations in the contracts, an action's own where a parameter says it (`takes`), and what
expressions come to without a result, a clock or an own function. What is in the background counts as if it
were waited for.
"""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from typing import Any

from ...schemas import protocol as p
from ...schemas.quantity import UnitError, magnitude_in, seconds
from ..language.expression import ExpressionError
from ..language.value import value_of
from ..run.shortest import Leg
from ..survey.survey import Survey

NOBODY: frozenset[str] = frozenset()
UNKNOWN = (ExpressionError, UnitError, ValueError, TypeError, KeyError, ArithmeticError)


class Legs:
    """The legs of steps of one protocol; `of` is asked for each iteration."""

    def __init__(self, survey: Survey) -> None:
        self.survey = survey

    def of(self, steps: Iterable[p.Step], names: Mapping[str, Any]) -> list[Leg]:
        """What these steps do with these names; neighbours on the same devices are one."""
        merged: list[Leg] = []
        known = {
            **names,
            "steps": names["steps"].known(),
        }  # of others it is not said that they are null
        for devices, took_s in self._sequence(steps, known):
            if merged and merged[-1][0] == devices:
                took_s += merged.pop()[1]
            merged.append((devices, took_s))
        return merged

    def _sequence(self, steps: Iterable[p.Step], names: dict[str, Any]) -> Iterator[Leg]:
        for step in steps:
            if step.when is None or self._value(step.when, names, True):
                yield from self._step(step, names)

    def _step(self, step: p.Step, names: dict[str, Any]) -> Iterator[Leg]:
        match step:
            case p.Do():
                yield self._action(step, names)
            case p.Parallel() | p.AnyOf():
                members = [list(self._step(one, dict(names))) for one in getattr(step, step.KIND)]
                yield _together([leg for one in members for leg in one], _longest(members))
            case p.Group() if step.reserve:
                inner = list(self._sequence(step.steps, names))
                kept = frozenset(self.survey.roles[role].device for role in step.reserve)
                yield _together([*inner, (kept, 0.0)], sum(took for _, took in inner))
            case p.Group():
                yield from self._sequence(step.steps, names)
            case p.Wait():
                yield NOBODY, 0.0 if step.until is not None else self._seconds(step.wait, names)
            case p.If():
                chosen = step.then if self._value(step.if_, names, True) else step.else_
                yield from self._sequence(chosen or (), names)
            case p.Set():
                names.update({n: self._value(raw, names, None) for n, raw in step.set.items()})
            case p.Foreach():
                ((name, raw),) = step.foreach.items()
                for item in self._value(raw, names, ()):
                    yield from self._sequence(step.steps, {**names, name: item})
            case p.Repeat():
                for _ in range(self._value(step.repeat, names, 1)):
                    yield from self._sequence(step.steps, dict(names))
            case p.While():
                yield from self._sequence(step.steps, dict(names))
            case p.Use():
                yield from self._used(step, names)
            case _:
                pass

    def _action(self, step: p.Do, names: Mapping[str, Any]) -> Leg:
        role_name, _, action_name = step.do.partition(".")
        role = self.survey.roles[role_name]
        action = role.contract.actions[action_name]
        given = {}
        if action.takes in step.with_:
            unit = action.param_schemas()[action.takes]["unit"]
            with suppress(*UNKNOWN):
                value = value_of(step.with_[action.takes]).evaluate(names)
                given = {action.takes: float(magnitude_in(value, unit))}
        free = role.contract.concurrent or action.meanwhile
        return NOBODY if free else frozenset([role.device]), action.typical_s(given) or 0.0

    def _used(self, step: p.Use, names: Mapping[str, Any]) -> Iterator[Leg]:
        used = next(one for one in self.survey.used.values() if one.step is step)
        params = {
            name: self._value(step.with_.get(name, param.default), names, None)
            for name, param in used.survey.protocol.params.items()
        }
        yield from Legs(used.survey)._sequence(
            used.survey.protocol.steps, {"params": params, "steps": {}}
        )

    def _seconds(self, raw: Any, names: Mapping[str, Any]) -> float:
        with suppress(*UNKNOWN):
            return seconds(value_of(raw).evaluate(names))
        return 0.0

    def _value(self, raw: Any, names: Mapping[str, Any], otherwise: Any) -> Any:
        with suppress(*UNKNOWN):
            return value_of(raw).evaluate(names)
        return otherwise


def _together(legs: list[Leg], lasts_s: float) -> Leg:
    """Steps that keep all their devices until the last of them is over."""
    return frozenset().union(*(devices for devices, _ in legs)), lasts_s


def _longest(members: list[list[Leg]]) -> float:
    return max((sum(took for _, took in legs) for legs in members), default=0.0)
