"""A step's id is its permanent name: in results, in the journal, on the page.

E401. Two steps with the same id cannot be told apart: `steps.ID` could mean either, and when a
run is resumed, a journal record of one would be taken for the other.

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

E407. A name defined by a loop or a `set` must not already have a meaning in expressions (`params`,
`steps`, `run`, `error`, `true`, functions such as `span`), and an inner loop must not reuse the
name of an outer one. The id of a step in a group with a `fallback` or `retry` must not be `f1`,
`a2` or `r2`: these are the journal's names for the group's first fallback and its second attempts.

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

W423. A name of the protocol's own may be spelt like a function: `${{ mean }}` is then the value, and
`${{ mean(values) }}` still the function. Whoever reads it has to know.

Passes:

    devices: {balance: balance@1}
    steps:
      - {id: weight, do: balance.weigh}
      - set: {average: "${{ mean([steps.weight.mass, 2 g]) }}"}
      - log: ${{ average }}

Fails:

    devices: {balance: balance@1}
    steps:
      - {id: weight, do: balance.weigh}
      - set: {mean: "${{ mean([steps.weight.mass, 2 g]) }}"}
      - log: ${{ mean }}
"""

import re
from collections.abc import Iterator

from ...schemas.problem import Problem
from ...schemas.protocol import AnyOf, Foreach, Group, Parallel, Set
from ..language.functions import FUNCTIONS
from ..survey.scope import RESERVED
from .context import Context

CODES = {
    "E401": "an id that is used twice",
    "E407": "a name that already means something else",
    "W423": "a name that is a function's, too",
}


def check(context: Context) -> Iterator[Problem]:
    """Every id, every loop name, every `set` name."""
    source = context.source
    for name, place, first in context.survey.twice:
        line = source.place((*first, "id"))[0]
        message = f"the step in line {line} already has the id {name!r}"
        if source.place((*place, "id")) == source.place((*first, "id")):
            message = f"an alias repeats this step, and its id {name!r} with it"
        yield source.problem((*place, "id"), "E401", message, "give each step a different id")
    yield from _marks(context)
    for name in context.protocol.functions:
        if name in FUNCTIONS and name not in RESERVED:
            message = f"{name}(...) is the protocol's own function here, not that of the language"
            yield source.problem(
                ("functions", name), "W423", message, "choose another name", key=True
            )
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
    """Ids that the journal gives to the fallbacks and attempts of the enclosing group."""
    held = {at.place: at.step for at in context.survey.steps}
    for at in context.survey.steps:
        around = held.get(at.place[:-2])
        if at.step.id is None or not isinstance(around, Group | Parallel | AnyOf):
            continue
        marks = ("fa" if around.fallback else "") + ("r" if around.retry else "")
        if marks and re.fullmatch(f"[{marks}][0-9]+", at.step.id):
            message = (
                f"{at.step.id} is the journal's name for a fallback or an attempt of the group"
            )
            place = (*at.place, "id")
            yield context.source.problem(place, "E407", message, "choose another id")


def _taken(
    context: Context, place: tuple[str | int, ...], name: str, around: list[str]
) -> Iterator[Problem]:
    if name in RESERVED:
        message = f"{name} already means something else in expressions"
        yield context.source.problem(place, "E407", message, "choose another name", key=True)
    elif name in around:
        message = f"{name} is already the name of an enclosing loop"
        yield context.source.problem(place, "E407", message, "choose another name", key=True)
    elif name in FUNCTIONS:
        message = f"{name} is a function's name, too: {name}(...) is still the function"
        yield context.source.problem(place, "W423", message, "choose another name", key=True)
