"""A step's id is its name for good: in results, in the journal, on the page.

E401. Two steps of one id have one name: nobody could say which of them `steps.ID` means, and
what the journal says of the one would be taken for the other when a run goes on.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - {id: first, do: gantry.home}
      - {id: again, do: gantry.home}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - {id: first, do: gantry.home}
      - {id: first, do: gantry.home}

E407. A name that a loop or a `set` gives is not one that expressions know already (`params`,
`steps`, `run`, `error`, functions, `true`), and a loop within a loop does not use its name again.
The id of a step in a group with a `fallback` or `retry` is not `f1`, `a2` or `r2`: so the journal
calls the group's first fallback and its second turns.

Passes:

    devices: {gantry: gantry@1}
    steps:
      - foreach: {x: [1 mm, 2 mm]}
        steps:
          - foreach: {y: [1 mm, 2 mm]}
            steps:
              - {do: gantry.move_to, with: {x: "${{ x }}", y: "${{ y }}"}}

Fails:

    devices: {gantry: gantry@1}
    steps:
      - foreach: {x: [1 mm, 2 mm]}
        steps:
          - foreach: {x: [1 mm, 2 mm]}
            steps:
              - {do: gantry.move_to, with: {x: "${{ x }}", y: "${{ x }}"}}
"""

import re
from collections.abc import Iterator

from ...schemas.problem import Problem
from ...schemas.protocol import AnyOf, Foreach, Group, Parallel, Set
from ..context import Context
from ..language.scope import RESERVED

CODES = {
    "E401": "an id that is there twice",
    "E407": "a name that means something else already",
}


def check(context: Context) -> Iterator[Problem]:
    """Every id, every loop name, every `set` name."""
    source = context.source
    for name, place, first in context.survey.twice:
        line = source.place((*first, "id"))[0]
        message = f"the id {name!r} is that of the step in line {line} already"
        yield source.problem((*place, "id"), "E401", message, "give each step an id of its own")
    yield from _marks(context)
    for step, at in context.steps(Foreach):
        name = next(iter(step.foreach))
        around = [loop.name for loop in at.env.loops]
        yield from _taken(context, (*at.place, "foreach", name), name, around)
    for step, at in context.steps(Set):
        for name in step.set:
            yield from _taken(
                context, (*at.place, "set", name), name, [loop.name for loop in at.env.loops]
            )


def _marks(context: Context) -> Iterator[Problem]:
    """Ids that the journal gives to the fallbacks and turns of the group around them."""
    held = {at.place: at.step for at in context.survey.steps}
    for at in context.survey.steps:
        around = held.get(at.place[:-2])
        if at.step.id is None or not isinstance(around, Group | Parallel | AnyOf):
            continue
        marks = ("fa" if around.fallback else "") + ("r" if around.retry else "")
        if marks and re.fullmatch(f"[{marks}][0-9]+", at.step.id):
            message = f"{at.step.id} is what the journal calls a fallback or a turn of the group"
            place = (*at.place, "id")
            yield context.source.problem(place, "E407", message, "choose another id")


def _taken(
    context: Context, place: tuple[str | int, ...], name: str, around: list[str]
) -> Iterator[Problem]:
    if name in RESERVED:
        message = f"{name} means something else in expressions already"
        yield context.source.problem(place, "E407", message, "choose another name", key=True)
    elif name in around:
        message = f"{name} is the name of a loop around this already"
        yield context.source.problem(place, "E407", message, "choose another name", key=True)
