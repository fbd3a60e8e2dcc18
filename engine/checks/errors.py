"""`retry: {on: [...]}` names errors that the action can end with.

An error name is one of those that the contract declares for the action, or one of the four that
every action may end with: Timeout, Busy, Rejected and Lost. A misspelt name would silently mean
that nothing is tried again.

Passes:

    labrun: 1
    name: errors
    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home
        retry: {attempts: 2, on: [HomingFailed, Timeout]}

Fails (E211):

    labrun: 1
    name: errors
    devices: {gantry: gantry@1}
    steps:
      - do: gantry.home
        retry: {attempts: 2, on: [HomingFaild]}
"""

from collections.abc import Iterator

from ...schemas.contract import RESERVED_ERRORS
from ...schemas.problem import Problem
from ...schemas.protocol import Do, Retry
from ..context import Context
from ..language.spots import StepAt
from ..language.suggest import did_you_mean, listed

CODES = {"E211": "an error name that the action does not declare"}


def check(context: Context) -> Iterator[Problem]:
    """Every `retry` that has an `on`."""
    for at in context.survey.steps:
        retry = at.step.retry
        if not isinstance(retry, Retry) or not retry.on:
            continue
        known = _declared(context, at)
        if known is None:
            continue
        for index, name in enumerate(retry.on):
            if name not in known:
                place = (*at.place, "retry", "on", index)
                what = f"{at.step.do} " if isinstance(at.step, Do) else "nothing in this step "
                message = f"{what}declares no error {name}{did_you_mean(name, known)}"
                yield context.source.problem(place, "E211", message, f"known: {listed(known)}")


def _declared(context: Context, at: StepAt) -> set[str] | None:
    """Errors of the action, or of all actions in the step; None where one is not known."""
    names: set[str] = set()
    for step, inner in context.steps(Do):
        if inner.place[: len(at.place)] == at.place:
            found = context.action(step)
            if found is None:
                return None
            names.update(found[1].errors)
    own = {"Expression", "Required", "Fail"} if not isinstance(at.step, Do) else set()
    return names | set(RESERVED_ERRORS) | own
