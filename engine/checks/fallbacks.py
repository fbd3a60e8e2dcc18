"""An alternative returns what the step would have returned; an `ask` in a fallback asks what to do.

E312. If a step fails, its result is that of the alternative that succeeded, so each alternative
must return the fields that other steps use.

Passes:

    devices: {libs: libs_analyzer@1}
    steps:
      - id: shoot
        do: libs.measure
        fallback:
          - steps:
              - do: libs.reconnect
              - do: libs.measure
      - {do: libs.export, with: {shot: "${{ steps.shoot.shot_id }}", file: a.csv}}
    finally: [{do: libs.disarm}]

Fails:

    devices: {libs: libs_analyzer@1}
    steps:
      - id: shoot
        do: libs.measure
        fallback:
          - do: libs.reconnect
      - {do: libs.export, with: {shot: "${{ steps.shoot.shot_id }}", file: a.csv}}
    finally: [{do: libs.disarm}]

E408. An `ask` in a fallback decides how the run continues. Its choices are `repeat` (run the step
again), `skip` (skip this iteration) and `stop`; any other choice would have no meaning.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home
        fallback:
          - {ask: No zero was found, choices: [repeat, stop]}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home
        fallback:
          - {ask: No zero was found, choices: [again, stop]}
"""

import ast
from collections.abc import Iterator
from typing import Any

from ...schemas.problem import Problem
from ...schemas.protocol import Ask, Do, Group
from ..language.expression import step_of
from ..language.suggest import did_you_mean, listed
from ..language.types import ANY, NULL, Type, type_of_schema
from ..survey.spots import StepAt
from .context import Context

CODES = {
    "E312": "an alternative that does not return what the step returns",
    "E408": "a choice that a fallback does not have",
}
CHOICES = ("repeat", "skip", "stop")


def check(context: Context) -> Iterator[Problem]:
    """Every step with a fallback."""
    used = _used_fields(context)
    for at in context.survey.steps:
        for index, alternative in enumerate(at.step.fallback):
            place = (*at.place, "fallback", index)
            if isinstance(alternative, Ask):
                yield from _choices(context, alternative, place)
            else:
                yield from _returns(context, at, alternative, place, used)


def _choices(context: Context, ask: Ask, place: tuple[str | int, ...]) -> Iterator[Problem]:
    for index, choice in enumerate(ask.choices):
        if choice not in CHOICES:
            message = f"a fallback has no choice {choice}{did_you_mean(choice, CHOICES)}"
            yield context.source.problem(
                (*place, "choices", index), "E408", message, f"its choices are {listed(CHOICES)}"
            )


def _returns(
    context: Context, at: StepAt, alternative: Any, place: tuple[str | int, ...],
    used: dict[str, set[str]],
) -> Iterator[Problem]:  # fmt: skip
    name = at.step.id
    if name is None or name not in context.survey.ids:
        return
    wanted, given = context.survey.ids[name].type, _result(context, alternative)
    if wanted.kind != "map" or given.kind == "any":
        return
    read = used.get(name, set())
    missing = [
        f for f in wanted.fields if f in read and f not in given.fields and given.rest is None
    ]
    if missing:
        returned = listed(given.fields) if given.fields else "nothing"
        message = (
            f"this alternative returns {returned}; steps.{name}.{missing[0]} is used by other steps"
        )
        yield context.source.problem(
            place, "E312", message, "end it with a step that returns the same fields"
        )


def _result(context: Context, step: Any) -> Type:
    """The type that an alternative returns; for a list, that of its last step."""
    if isinstance(step, list):
        return _result(context, step[-1]) if step else NULL
    if isinstance(step, Group):
        return _result(context, step.steps[-1])
    if isinstance(step, Do):
        found = context.survey.action(step)
        return type_of_schema(found[1].returns, root=True) if found else ANY
    return ANY


def _used_fields(context: Context) -> dict[str, set[str]]:
    """Step id -> the fields of its result that expressions read."""
    found: dict[str, set[str]] = {}
    for spot in context.survey.spots:
        if isinstance(spot.value, Exception):
            continue
        for expression in spot.value.expressions():
            for node in ast.walk(expression.tree):
                if isinstance(node, ast.Attribute) and (step := step_of(node.value)) is not None:
                    found.setdefault(step, set()).add(node.attr)
    return found
