"""What is repeated can be repeated: an action that counts only `once` is not done again unasked.

`retry` on a group starts the group anew, with every action in it. Where one of them is `once` in
its contract (a laser shot, a dispensed drop), put the `retry` on the action itself: there only
what surely did not happen is sent again.

Passes:

    labrun: 1
    name: repeats
    devices: {libs: libs_analyzer@1}
    steps:
      - steps:
          - {do: libs.measure, timeout: 15 s, retry: 3}

Fails (W405, a warning):

    labrun: 1
    name: repeats
    devices: {libs: libs_analyzer@1}
    steps:
      - retry: 3
        steps:
          - {do: libs.measure, timeout: 15 s}
"""

from collections.abc import Iterator

from ...schemas.problem import Problem
from ...schemas.protocol import Do, Parallel
from ..context import Context
from ..language.spots import StepAt

CODES = {
    "W405": "a `once` action in a group that is repeated as a whole",
    "W406": "`on_unknown` where it does nothing",
}


def check(context: Context) -> Iterator[Problem]:
    """Every `retry` on a group, every `on_unknown`."""
    once = [(step.do, at) for step, at, _, action in context.actions() if action.effect == "once"]
    for at in context.survey.steps:
        if at.step.retry is not None and not isinstance(at.step, Do | Parallel):
            yield from _group(context, at, once)
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


def _group(context: Context, at: StepAt, once: list[tuple[str, StepAt]]) -> Iterator[Problem]:
    inside = [name for name, inner in once if inner.place[: len(at.place)] == at.place]
    if inside:
        message = f"this retry does {inside[0]} again, which its contract says is to be done once"
        hint = "put the `retry` on the action itself"
        yield context.source.problem(
            (*at.place, "retry"), "W405", message, hint, key=True, severity="warning"
        )
