"""What is repeated can be repeated: an action that counts only `once` is not done again unasked.

W405. `retry` on a group starts the group anew, with every action in it. Where one of them is
`once` in its contract (a laser shot, a dispensed drop), put the `retry` on the action itself:
there only what surely did not happen is sent again.

Passes:

    devices: {libs: libs_analyzer@1}
    steps:
      - steps:
          - {do: libs.measure, retry: 3}
    finally: [{do: libs.disarm}]

Fails:

    devices: {libs: libs_analyzer@1}
    steps:
      - retry: 3
        steps:
          - do: libs.measure
    finally: [{do: libs.disarm}]

W406. `on_unknown` decides after a crash or a lost server what becomes of a `once` action whose
fate nobody knows. Any other action is simply repeated, and without a `probe` in the contract
there is nothing to probe.

Passes:

    devices: {libs: libs_analyzer@1}
    steps:
      - {do: libs.measure, on_unknown: ask}
    finally: [{do: libs.disarm}]

Fails:

    devices: {libs: libs_analyzer@1}
    steps:
      - {do: libs.measure, on_unknown: ask}
      - {do: libs.export, with: {shot: a, file: a.csv}, on_unknown: ask}
    finally: [{do: libs.disarm}]
"""

from collections.abc import Iterator

from ...schemas.problem import Problem
from ...schemas.protocol import Do, Parallel, StepBase
from ..context import Context
from ..language.shape import Place
from ..language.spots import StepAt
from ..language.used import Used
from .within import within

CODES = {
    "W405": "a `once` action in a group that is repeated as a whole",
    "W406": "`on_unknown` where it does nothing",
}


def check(context: Context) -> Iterator[Problem]:
    """Every `retry` on a group, every `on_unknown`."""
    for at in context.survey.steps:
        if at.step.retry is not None and not isinstance(at.step, Do | Parallel):
            yield from _group(context, at)
    for step, at, _, action in context.actions():
        place = (*at.place, "on_unknown")
        if step.on_unknown is not None and action.effect != "once":
            message = (
                f"on_unknown does nothing here: {step.do} is {action.effect} and may be repeated"
            )
            yield context.source.problem(place, "W406", message, severity="warning")
        elif step.on_unknown == "probe" and action.probe is None:
            message = f"{step.do} has no probe: a person is asked at once"
            yield context.source.problem(place, "W406", message, severity="warning")


def _group(context: Context, at: StepAt) -> Iterator[Problem]:
    again = next(_once(context, at.step, at.place), None)
    if again is not None:
        message = f"this retry does {again} again, which its contract says is to be done once"
        hint = "put the `retry` on the action itself"
        yield context.source.problem(
            (*at.place, "retry"), "W405", message, hint, key=True, severity="warning"
        )


def _once(context: Context, step: StepBase, place: Place) -> Iterator[str]:
    """Actions in a step, also in protocols that it uses, that are done once."""
    for inner, at in within(step, place):
        if isinstance(inner, Do):
            found = context.action(inner)
            if found is not None and found[1].effect == "once":
                yield inner.do
        used = context.survey.used.get(at)
        if used is not None:
            yield from _once_in(used)


def _once_in(used: Used) -> Iterator[str]:
    for at in used.survey.steps:
        step = at.step
        if isinstance(step, Do):
            role, _, name = step.do.partition(".")
            bound = used.roles.get(role)
            action = bound.contract.actions.get(name) if bound is not None else None
            if action is not None and action.effect == "once":
                yield f"{step.do} of {used.step.use}"
        elif at.place in used.survey.used:
            yield from _once_in(used.survey.used[at.place])
