"""The text between `${{` and `}}` is a valid expression.

E300. Expressions are written as in Python: arithmetic, comparisons, `and or not`,
`a if b else c`, fields `a.b`, items `a[0]`, lists, `[a.b for a in c]`, and functions: grid, span,
csv, range, len, min, max, round, format, and those that calculate, such as mean. A number followed
by a unit is a quantity: `0.1 mm`. Expressions have no side effects: no assignments, no imports, no
other functions.

Passes:

    params: {pitch: {type: quantity, unit: mm, default: 0.2 mm}}
    devices: {gantry: gantry@1}
    steps:
      - do: gantry.move_to
        with: {x: "${{ params.pitch + 0.1 mm }}"}

Fails:

    params: {pitch: {type: quantity, unit: mm, default: 0.2 mm}}
    devices: {gantry: gantry@1}
    steps:
      - do: gantry.move_to
        with: {x: "${{ params.pitch + }}"}
"""

from collections.abc import Iterator

from ...schemas.problem import Problem
from .context import Context

CODES = {"E300": "an expression that cannot be read"}


def check(context: Context) -> Iterator[Problem]:
    """Every place that may hold an expression."""
    for spot in context.survey.spots:
        if isinstance(spot.value, Exception):
            yield context.source.problem(spot.place, "E300", str(spot.value))
