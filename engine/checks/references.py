"""What an expression names exists, has a value at that place, and has that field.

`params.NAME` is a parameter. `steps.ID.FIELD` is a field of the result of a step that has run
before: what an action returns is in its contract; a loop's result has total, succeeded, failed
and skipped; `confirm` and `ask` return choice. What is inside a loop is known inside it only; what
is in a fallback, within that fallback. The result of a background action is known in `collect`
and `outputs`. `error` is known in a fallback: name, message, step, device, action.

Passes:

    labrun: 1
    name: references
    devices: {libs: libs_analyzer@1}
    steps:
      - {id: shoot, do: libs.measure, timeout: 15 s}
      - {do: libs.export, with: {shot: "${{ steps.shoot.shot_id }}", file: a.csv}}

Fails (E301):

    labrun: 1
    name: references
    devices: {libs: libs_analyzer@1}
    steps:
      - {id: shoot, do: libs.measure, timeout: 15 s}
      - {do: libs.export, with: {shot: "${{ steps.shoot.shotid }}", file: a.csv}}
"""

from collections.abc import Iterator

from ...schemas.problem import Problem
from ..context import Context

CODES = {
    "E301": "a field that the result or value does not have",
    "E302": "a name that does not exist",
    "E303": "a parameter that does not exist",
    "E304": "a step id that does not exist",
    "E305": "a step that has not run yet at this place",
    "E306": "a name that is known only inside a loop, a fallback or another phase",
    "E310": "the result of a background action where it is not known",
    "E311": "`error` outside a fallback",
    "E313": "a table that cannot be read, or does not fit",
}


def check(context: Context) -> Iterator[Problem]:
    """Every expression, by the names in it."""
    for spot in context.survey.spots:
        for fault in spot.inferred()[1]:
            if fault.code in CODES:
                yield context.source.problem(spot.place, fault.code, fault.message, fault.hint)
