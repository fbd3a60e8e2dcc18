"""Steps within a step, each with its place; not a check, but a helper of several checks."""

from collections.abc import Iterator, Sequence
from typing import Any

from ...schemas.protocol import StepBase, inner_lists, thens
from ..language.shape import Place

STOPS = (None, "stop")


def within(
    step: StepBase, place: Place, *, fallbacks: bool = True
) -> Iterator[tuple[StepBase, Place]]:
    """The step itself, then everything in it, in the order of the file."""
    left: list[tuple[Any, Place]] = [(step, place)]
    while left:
        here, at = left.pop()
        if isinstance(here, list):
            left += [(one, (*at, index)) for index, one in reversed(list(enumerate(here)))]
            continue
        yield here, at
        held: list[tuple[Any, Place]] = [(steps, (*at, key)) for key, steps in inner_lists(here)]
        if fallbacks and here.fallback:
            held.append((here.fallback, (*at, "fallback")))
        if fallbacks:
            held += [(then, (*at, *keys)) for then, keys in thens(here)]
        left += reversed(held)


def lists(steps: Sequence[Any], place: Place) -> Iterator[tuple[Sequence[Any], Place]]:
    """A list of steps and every list of steps that run one after the other within it."""
    yield steps, place
    for index, step in enumerate(steps):
        for inner, at in within(step, (*place, index)):
            for key, held in inner_lists(inner):
                if key not in ("parallel", "any"):
                    yield held, (*at, key)
            for number, alternative in enumerate(inner.fallback):
                if isinstance(alternative, list):
                    yield alternative, (*at, "fallback", number)
            for then, keys in thens(inner):
                if isinstance(then, list):
                    yield then, (*at, *keys)
