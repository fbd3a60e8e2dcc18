"""A `while` ends: it has a limit, and its steps change what its condition depends on.

W411. A `while` runs as long as its condition is true. With `max` it fails with the error
MaxReached after that many iterations; without it, a reading that never arrives keeps the
instrument busy all night.

Passes:

    devices: {balance: balance@1}
    steps:
      - set: {mass: "${{ 0 g }}"}
      - while: ${{ mass < 5 g }}
        max: 20
        steps:
          - {id: weight, do: balance.weigh}
          - set: {mass: "${{ steps.weight.mass }}"}

Fails:

    devices: {balance: balance@1}
    steps:
      - set: {mass: "${{ 0 g }}"}
      - while: ${{ mass < 5 g }}
        steps:
          - {id: weight, do: balance.weigh}
          - set: {mass: "${{ steps.weight.mass }}"}

W412. The condition of a `while` is computed again before each iteration. Where no `set` in the
loop, or in another member of a set that the loop is in, changes a name in it, it stays the same: the
loop never runs, or runs `max` times and fails.

Passes:

    devices: {balance: balance@1}
    steps:
      - set: {mass: "${{ 0 g }}"}
      - while: ${{ mass < 5 g }}
        max: 20
        steps:
          - {id: weight, do: balance.weigh}
          - set: {mass: "${{ steps.weight.mass }}"}

Fails:

    devices: {balance: balance@1}
    steps:
      - {id: weight, do: balance.weigh}
      - while: ${{ steps.weight.mass < 5 g }}
        max: 20
        steps:
          - {do: balance.weigh, with: {patience: 60 s}}
"""

from collections.abc import Iterator

from ...schemas.problem import Problem
from ...schemas.protocol import Set, While
from ..language.value import Value
from ..survey.spots import StepAt
from .constant import constant
from .context import Context
from .within import within

CODES = {
    "W411": "a `while` without `max`",
    "W412": "a `while` that never changes its condition",
}


def check(context: Context) -> Iterator[Problem]:
    """Every `while`."""
    conditions = {
        spot.place[:-1]: spot
        for spot in context.survey.spots
        if spot.use == "condition" and spot.what == "while"
    }
    for step, at in context.steps(While):
        spot = conditions.get(at.place)
        if spot is not None and isinstance(spot.value, Value) and spot.value.live:
            continue  # the clock changes it
        if step.max is None and not constant(step.while_).known:
            message = "this `while` may run for ever: it has no `max`"
            hint = "add the most iterations that make sense, such as `max: 100`"
            yield context.source.problem((*at.place, "while"), "W411", message, hint, key=True)
        if spot is not None and not isinstance(spot.value, Exception) and not spot.inferred()[1]:
            yield from _unchanged(context, step, at, spot.value.names)


def _beside(context: Context, at: StepAt) -> set[str]:
    """Names that other members of the sets around a step give a value while it runs."""
    found: set[str] = set()
    for depth, part in enumerate(at.place[:-1]):
        if part in ("parallel", "any") and isinstance(at.place[depth + 1], int):
            member = at.place[: depth + 2]
            found |= {
                name
                for step, other in context.steps(Set)
                if other.place[: depth + 1] == at.place[: depth + 1]
                and other.place[: depth + 2] != member
                for name in step.set
            }
    return found


def _unchanged(context: Context, step: While, at: StepAt, names: set[str]) -> Iterator[Problem]:
    if not names or "run" in names:
        return
    changed = {
        name for inner, _ in within(step, at.place) if isinstance(inner, Set) for name in inner.set
    }
    if names & changed or names & _beside(context, at):
        return
    message = "nothing in this loop changes what its condition depends on"
    hint = "use a name here that a `set` in the loop changes"
    yield context.source.problem((*at.place, "while"), "W412", message, hint)
