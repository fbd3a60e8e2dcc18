"""`retry: {on: [...]}` names errors that the action can end with.

E211. An error name must be one that the contract declares for the action, or one of the four that
any action may end with: Timeout, Busy, Rejected and Lost. With a misspelt name nothing would be
retried, and nothing would show why.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.home, retry: {attempts: 2, on: [HomingFailed, Timeout]}}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.home, retry: {attempts: 2, on: [HomingFaild, Timeout]}}
"""

from collections.abc import Iterator

from ...schemas.contract import RESERVED_ERRORS
from ...schemas.problem import Problem
from ...schemas.protocol import Do, Retry, Use
from ..language.load import Broken
from ..language.suggest import did_you_mean, listed
from ..survey.spots import StepAt
from .context import Context
from .within import within

CODES = {"E211": "an error name that the action does not declare"}
OWN = {"fail": {"Failed"}, "require": {"Required"}, "while": {"MaxReached"}, "confirm": {"Refused"}}
"""The errors of steps that use no device."""


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
                declares = "nothing in this step declares an error"
                if isinstance(at.step, Do):
                    declares = f"{at.step.do} declares no error"
                message = f"{declares} {name}{did_you_mean(name, sorted(known))}"
                yield context.source.problem(
                    place, "E211", message, f"known: {listed(sorted(known))}"
                )


def _declared(context: Context, at: StepAt) -> set[str] | None:
    """Errors of the action, or of all actions in the step; None where an action is not known."""
    names: set[str] = set()
    for step, _ in within(at.step, at.place):
        names |= OWN.get(step.KIND, set())
        if isinstance(step, Broken | Use):
            return None
        if isinstance(step, Do):
            found = context.survey.action(step)
            if found is None:
                return None
            names.update(found[1].errors)
    if not isinstance(at.step, Do):
        names.add("Expression")
    return names | set(RESERVED_ERRORS)
