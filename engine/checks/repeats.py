"""Only repeatable actions are repeated: a `once` action is not repeated by accident.

W405. `retry` on a group runs the whole group again, with every action in it. If one of them is
`once` in its contract (a laser shot, a dispensed drop), put the `retry` on the action itself:
there it is sent again only if it certainly did not happen.

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

W406. After a crash or a lost server, `on_unknown` decides what to do about a `once` action that
may or may not have happened. Any other action is simply repeated, and without a `probe` in the
contract there is nothing to probe.

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
from ..language.shape import Place
from ..survey.spots import StepAt
from ..survey.survey import Used
from .context import Context
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
    for step, at, _, action in context.survey.actions():
        place = (*at.place, "on_unknown")
        if step.on_unknown is not None and action.effect != "once":
            message = (
                f"on_unknown does nothing here: {step.do} is {action.effect} and may be repeated"
            )
            yield context.source.problem(place, "W406", message)
        elif step.on_unknown == "probe" and action.probe is None:
            message = f"{step.do} has no probe: a person is asked immediately"
            yield context.source.problem(place, "W406", message)


def _group(context: Context, at: StepAt) -> Iterator[Problem]:
    again = next(_once(context, at.step, at.place), None)
    if again is not None:
        message = f"this retry repeats {again}, which is `once` in its contract"
        hint = "put the `retry` on the action itself"
        yield context.source.problem((*at.place, "retry"), "W405", message, hint, key=True)


def _once(context: Context, step: StepBase, place: Place) -> Iterator[str]:
    """The `once` actions in a step, including those in protocols that it uses."""
    for inner, at in within(step, place):
        if isinstance(inner, Do):
            found = context.survey.action(inner)
            if found is not None and found[1].effect == "once":
                yield inner.do
        used = context.survey.used.get(at)
        if used is not None:
            yield from _once_in(used)


def _once_in(used: Used) -> Iterator[str]:
    for at in used.survey.steps:
        step = at.step
        if isinstance(step, Do):
            found = used.survey.action(step)
            if found is not None and found[1].effect == "once":
                yield f"{step.do} of {used.step.use}"
        elif at.place in used.survey.used:
            yield from _once_in(used.survey.used[at.place])
