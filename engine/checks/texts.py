"""A value that is computed with is a quantity, not the text of one.

W420. `0 g` between no braces is a text. Where an action wants a mass it is taken for one, but a
`set` wants nothing in particular: the name stands for the text, and comparing or adding it fails
when the run comes to it. `${{ 0 g }}` is the quantity.

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
      - set: {mass: 0 g}
      - while: ${{ mass < 5 g }}
        max: 20
        steps:
          - {id: weight, do: balance.weigh}
          - set: {mass: "${{ steps.weight.mass }}"}
"""

import ast
from collections.abc import Iterator

from ...schemas.problem import Problem
from ...schemas.protocol import Set
from ...schemas.quantity import QUANTITY, UnitError, parse_quantity
from ..context import Context
from ..language.shape import Place

CODES = {"W420": "a text that looks like a quantity, and is computed with"}


def check(context: Context) -> Iterator[Problem]:
    """Every `set` of a text such as `5 mm` to a name that is used for more than itself."""
    looks = list(texts_like_quantities(context))
    if not looks:
        return
    computed = _computed_with(context)
    for place, name, value in looks:
        if name in computed:
            message = f"{name} is the text {value!r} here, and is computed with as a quantity"
            hint = as_quantity(name, value)
            yield context.source.problem(place, "W420", message, hint, severity="warning")


def texts_like_quantities(context: Context) -> Iterator[tuple[Place, str, str]]:
    """Place, name and text of each `set` of a text such as `5 mm`."""
    for step, at in context.steps(Set):
        for name, value in step.set.items():
            if isinstance(value, str) and _is_quantity(value):
                yield (*at.place, "set", name), name, value


def as_quantity(name: str, text: str) -> str:
    """What to write instead."""
    return f'write {name}: "${{{{ {text} }}}}"'


def _is_quantity(text: str) -> bool:
    if not QUANTITY.match(text):
        return False
    try:
        parse_quantity(text)
    except UnitError:
        return False
    return True


def _computed_with(context: Context) -> set[str]:
    """Names that stand in an expression with something else beside them, and nobody objects."""
    return {
        name
        for spot in context.survey.spots
        if not isinstance(spot.value, Exception) and not spot.inferred()[1]
        for one in spot.value.expressions()
        if not isinstance(one.tree.body, ast.Name)
        for name in one.names
    }
