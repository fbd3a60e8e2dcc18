"""Every step can be reached: nothing follows a step that always ends its list.

E403. After a `fail`, a `require` that is never true or a loop that never ends, the rest of the
list does not run; after an alternative that cannot fail, no other alternative is tried. Either
the step before lacks a condition (`when`), or the steps after it are left over from an earlier
version of the protocol.

Passes:

    devices: {libs: libs_analyzer@1}
    steps:
      - {id: last, do: libs.last_shot}
      - {fail: The analyser has forgotten its shots, when: "${{ steps.last.shot_id == null }}"}
      - {do: libs.export, with: {shot: "${{ steps.last.shot_id }}", file: last.csv}}

Fails:

    devices: {libs: libs_analyzer@1}
    steps:
      - {id: last, do: libs.last_shot}
      - fail: The analyser has forgotten its shots
      - {do: libs.export, with: {shot: "${{ steps.last.shot_id }}", file: last.csv}}
"""

from collections.abc import Iterator, Sequence
from typing import Any

from ...schemas.problem import Problem
from ...schemas.protocol import (
    Ask,
    Confirm,
    Do,
    Fail,
    Group,
    If,
    Log,
    Parallel,
    Repeat,
    Require,
    StepBase,
    Wait,
    While,
)
from ...schemas.protocol import Set as SetStep
from ..language.shape import Place
from .constant import always, constant, fixed_count, never
from .context import Context
from .within import STOPS, lists

CODES = {"E403": "a step that can never be reached"}


def check(context: Context) -> Iterator[Problem]:
    """Every list of steps, and every fallback."""
    protocol = context.protocol
    sections = {"on_resume": protocol.on_resume, "steps": protocol.steps}
    for name, section in {**sections, "finally": protocol.finally_}.items():
        for steps, place in lists(section, (name,)):
            yield from _sequence(context, steps, place)
    for at in context.survey.steps:
        yield from _alternatives(context, at.step, at.place)


def _sequence(context: Context, steps: Sequence[Any], place: Place) -> Iterator[Problem]:
    for index, step in enumerate(steps[:-1]):
        why = _why_it_ends(step)
        if why:
            line = context.source.place((*place, index))[0]
            message = f"this step is never reached: {why} in line {line} ends the list"
            hint = f"give {why} a `when`, or remove one of the two"
            yield context.source.problem((*place, index + 1), "E403", message, hint)
            return


def _why_it_ends(step: StepBase) -> str:
    """What ends the list that a step is in; empty where something may run after it."""
    unless = step.when is not None and not always(step.when)
    if unless or step.fallback or step.on_error not in STOPS:
        return ""
    if isinstance(step, Fail):
        return "the `fail`"
    if isinstance(step, Require) and never(step.require):
        return "the `require` that is never true"
    if isinstance(step, While) and step.max is None and always(step.while_) and not step.keep_going:
        return "the `while` that never ends"
    return _why_its_steps_end(step)


def _why_its_steps_end(step: StepBase) -> str:
    if isinstance(step, Group):
        return _first(step.steps)
    if isinstance(step, Parallel):
        return _first(step.parallel)
    if isinstance(step, Repeat) and not step.keep_going:
        return _first(step.steps) if (fixed_count(step.repeat) or 0) > 0 else ""
    if isinstance(step, If):
        then, other = _first(step.then), _first(step.else_ or [])
        return then if then and other else ""
    return ""


def _first(steps: Sequence[Any]) -> str:
    return next((why for step in steps if (why := _why_it_ends(step))), "")


def _alternatives(context: Context, step: StepBase, place: Place) -> Iterator[Problem]:
    for index, alternative in enumerate((step.fallback or [])[:-1]):
        if not cannot_fail(alternative):
            continue
        at = (*place, "fallback", index + 1)
        if isinstance(alternative, Ask):
            message = "this alternative is never tried: the `ask` before it decides"
            hint = "let the `ask` be the last alternative"
        else:
            message = "this alternative is never tried: the one before it cannot fail"
            hint = "put both into one alternative: `- [first, second]` or `- steps: [...]`"
        yield context.source.problem(at, "E403", message, hint)
        return


def cannot_fail(step: Any) -> bool:
    """True for a step, or a list of steps, that always succeeds."""
    if isinstance(step, list):
        return all(cannot_fail(one) for one in step)
    if step.when is not None or step.timeout is not None:
        return False
    if isinstance(step, Do) and step.on_error == "continue":
        return True
    if isinstance(step, Group):
        return cannot_fail(step.steps)
    if isinstance(step, Log):
        return constant(step.log).known
    if isinstance(step, Wait):
        return step.until is None and constant(step.wait).known
    if isinstance(step, SetStep):
        return all(constant(value).known for value in step.set.values())
    return isinstance(step, Ask) and not isinstance(step, Confirm)
