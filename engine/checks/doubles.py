"""A list of choices or names has no duplicates.

W415. A duplicate choice gives the person who is asked two identical buttons; a duplicate error
name or permitted value is often a misspelling of another one.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.home, retry: {attempts: 3, on: [Timeout, Busy]}}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - {do: gantry.home, retry: {attempts: 3, on: [Timeout, Timeout]}}
"""

from collections.abc import Iterator, Sequence
from typing import Any

from ...schemas.problem import Problem
from ...schemas.protocol import Ask, Retry
from ..language.operators import words
from ..language.shape import Place
from .context import Context

CODES = {"W415": "a list with a duplicate"}


def check(context: Context) -> Iterator[Problem]:
    """Choices of parameters and questions, and the errors of retries."""
    for name, param in context.protocol.params.items():
        yield from _twice(context, param.enum or [], ("params", name, "enum"))
    for at in context.survey.steps:
        step = at.step
        if isinstance(step, Ask):
            yield from _twice(context, step.choices, (*at.place, "choices"))
        if isinstance(step.retry, Retry):
            yield from _twice(context, step.retry.on or [], (*at.place, "retry", "on"))


def _twice(context: Context, items: Sequence[Any], place: Place) -> Iterator[Problem]:
    for index, item in enumerate(items):
        if item in items[:index]:
            message = f"{words(item)} is listed twice"
            yield context.source.problem(
                (*place, index), "W415", message, "remove one, or change it"
            )
