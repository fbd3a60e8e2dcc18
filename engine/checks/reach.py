"""Every step can be reached.

After `fail` nothing of the same list runs, unless the failure is conditional (`when`), has a
`fallback`, or goes on (`on_error: continue`). A fallback's alternatives end with an `ask`: the
person has decided then.

Passes:

    labrun: 1
    name: reach
    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home
      - fail: nothing to do yet

Fails (E403):

    labrun: 1
    name: reach
    devices: {gantry: gantry@1}
    steps:
      - fail: nothing to do yet
      - do: gantry.home
"""

from collections.abc import Iterator, Sequence
from typing import Any

from ...schemas.problem import Problem
from ...schemas.protocol import Ask, Fail, Foreach, Group, StepBase
from ..context import Context
from ..language.shape import Place

CODES = {
    "E403": "a step that can never be reached",
    "W403": "a step that never runs",
}


def check(context: Context) -> Iterator[Problem]:
    """Every list of steps, every fallback, every `when` that is no question."""
    protocol = context.protocol
    for name, steps in (
        ("steps", protocol.steps),
        ("on_resume", protocol.on_resume),
        ("finally", protocol.finally_),
    ):
        yield from _sequence(context, steps, (name,))
    for at in context.survey.steps:
        step = at.step
        if isinstance(step, Group | Foreach):
            yield from _sequence(context, step.steps, (*at.place, "steps"))
        yield from _alternatives(context, step, at.place)
        if step.when is False:
            place = (*at.place, "when")
            yield context.source.problem(
                place, "W403", "when: false; this step never runs", severity="warning"
            )


def _ends(step: Any) -> bool:
    """True for a step after which nothing of its list runs."""
    plain = step.when is None and not step.fallback and step.on_error in (None, "stop")
    return isinstance(step, Fail) and plain


def _sequence(context: Context, steps: Sequence[Any], place: Place) -> Iterator[Problem]:
    for index, step in enumerate(steps[:-1]):
        if _ends(step):
            line = context.source.place((*place, index))[0]
            message = f"this step is never reached: `fail` in line {line} ends the list"
            yield context.source.problem(
                (*place, index + 1),
                "E403",
                message,
                "give the `fail` a `when`, or remove one of them",
            )
            return


def _alternatives(context: Context, step: StepBase, place: Place) -> Iterator[Problem]:
    for index, alternative in enumerate((step.fallback or [])[:-1]):
        asks = isinstance(alternative, Ask) and alternative.when is None
        if asks:
            at = (*place, "fallback", index + 1)
            message = "this alternative is never tried: the `ask` before it decides"
            yield context.source.problem(
                at, "E403", message, "let the `ask` be the last alternative"
            )
