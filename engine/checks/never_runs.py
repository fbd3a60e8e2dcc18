"""Every step can run: no condition is always false.

W403. A condition that needs no parameter and no result is the same in every run. If it is false,
the step it guards never runs: often a step that was switched off for a test and forgotten.

Passes:

    params: {with_home: {type: boolean, default: true}}
    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.home, when: "${{ params.with_home }}"}
      - {do: gantry.move_to, with: {x: 10 mm}}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.home, when: false}
      - {do: gantry.move_to, with: {x: 10 mm}}
"""

from collections.abc import Iterator

from ...schemas.problem import Problem
from ...schemas.protocol import If, While
from ..language.shape import Place
from .constant import always, never
from .context import Context

CODES = {"W403": "a step that never runs"}


def check(context: Context) -> Iterator[Problem]:
    """Every condition."""
    for at in context.survey.steps:
        step = at.step
        if step.when is not None and never(step.when):
            yield _warning(context, (*at.place, "when"), "when", "this step never runs")
        if isinstance(step, If):
            yield from _branches(context, step, at.place)
        if isinstance(step, While) and never(step.while_):
            yield _warning(context, (*at.place, "while"), "while", "its steps never run")


def _branches(context: Context, step: If, place: Place) -> Iterator[Problem]:
    if never(step.if_):
        yield _warning(context, (*place, "if"), "if", "`then` never runs")
    elif always(step.if_) and step.else_:
        yield _warning(context, (*place, "if"), "if", "`else` never runs", says="true")


def _warning(
    context: Context, place: Place, key: str, what: str, *, says: str = "false"
) -> Problem:
    message = f"this `{key}` is always {says}: {what}"
    hint = "make it depend on something, such as ${{ params.NAME }}, or remove it"
    return context.source.problem(place, "W403", message, hint)
