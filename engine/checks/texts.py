"""A value used in calculations is a quantity, not text that looks like one.

W420. `0 g` without braces is text. Where an action expects a mass, it is read as one, but a `set`
expects no particular type: the name then holds the text, and comparing or adding it fails when
the run reaches that step. `${{ 0 g }}` is the quantity.

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
import re
from collections.abc import Iterator

from ...schemas.problem import Problem
from ...schemas.protocol import Do, Foreach, Set
from ...schemas.quantity import QUANTITY, UnitError, parse_quantity
from ..language.shape import Place
from ..language.value import Text
from ..survey.spots import Spot
from .context import Context

BARE = ("set", "collect", "output", "text")
"""Where any text is allowed, so that nothing else finds it."""
VALUES = ("set", "collect", "output", "argument")
"""Where a value keeps its type if nothing stands beside it."""
NAMED = re.compile(r"(?:params|steps)(?:\.[A-Za-z_]\w*)+")
BRACED = re.compile(r"(?<![${])\{\s*(([A-Za-z_]\w*)(?:\.[A-Za-z_]\w*)*)\s*\}(?!\})")
"""`{i}`, as Python and others insert a value."""
MOST = 4
"""Items of a loop that a hint repeats."""
CODES = {"W420": "text that looks like a quantity and is used in calculations"}


def check(context: Context) -> Iterator[Problem]:
    """Every text such as `steps.a.b`, and every `set` of `5 mm` to a name that is used in calculations."""
    for spot in context.survey.spots:
        if spot.use in BARE and isinstance(spot.raw, str) and _is_meant_as_expression(spot):
            message = f"`{spot.raw}` without `${{{{ }}}}` is plain text and is not replaced"
            hint = f'write "${{{{ {spot.raw} }}}}" for the value of the expression'
            yield context.source.problem(spot.place, "W101", message, hint)
        elif (
            spot.use in VALUES and isinstance(spot.value, Text) and (left := _left_over(spot.value))
        ):
            message = f"the `{left}` beside `${{{{ }}}}` makes text of the value"
            hint = f"write it without the `{left}`"
            yield context.source.problem(spot.place, "W101", message, hint)
        elif isinstance(spot.raw, str) and (name := _is_name(spot, context)):
            message = f"`{spot.raw}` is plain text, and nothing uses the {name} of the loop"
            hint = f'write "${{{{ {name} }}}}" for its value'
            yield context.source.problem(spot.place, "W101", message, hint)
        elif isinstance(spot.raw, str) and (found := _braced(spot)):
            message = f"`{found[0]}` with one brace is plain text and is not replaced"
            hint = f"write ${{{{ {found[1]} }}}} for the value of the expression"
            yield context.source.problem(spot.place, "W101", message, hint)
    looks = list(texts_like_quantities(context))
    if not looks:
        return
    computed = _computed_with(context)
    for place, name, value in looks:
        if name in computed:
            message = (
                f"{name} is the text {value!r} here, but is used in calculations as a quantity"
            )
            hint = as_quantity(name, value)
            yield context.source.problem(place, "W420", message, hint)


def _is_meant_as_expression(spot: Spot) -> bool:
    """`steps.a.b`, or `turn: turn + 1`."""
    own = re.escape(str(spot.place[-1]))
    counted = spot.use == "set" and re.fullmatch(rf"{own} ?[-+*/] ?[\w.]+.*", spot.raw)
    return bool(counted or NAMED.fullmatch(spot.raw))


def _is_name(spot: Spot, context: Context) -> str:
    """The name of a loop around a text that is this name, where nothing else in the loop uses it."""
    name = spot.raw.strip()
    if spot.use != "argument" or all(loop.name != name for loop in spot.env.loops):
        return ""
    used = any(
        name in one.names
        for other in context.survey.spots
        if not isinstance(other.value, Exception)
        for one in other.value.expressions()
    )
    return "" if used or name in _choices(spot, context) else name


def _choices(spot: Spot, context: Context) -> list[object]:
    """The only values of the parameter whose argument this is, where there are such."""
    for step, at in context.steps(Do):
        role, _, name = step.do.partition(".")
        if spot.place[: len(at.place)] == at.place and role in context.roles:
            action = context.roles[role].contract.actions.get(name)
            schemas = action.param_schemas() if action is not None else {}
            return schemas.get(str(spot.place[-1]), {}).get("enum", [])
    return []


def _braced(spot: Spot) -> re.Match[str] | None:
    """What stands in braces and is a name here."""
    known = {"params", "steps", "status", *(loop.name for loop in spot.env.loops)}
    for found in BRACED.finditer(spot.raw) if "{" in spot.raw and "\\" not in spot.raw else ():
        if found[2] in known or found[2] in spot.env.set_names():
            return found
    return None


def texts_like_quantities(context: Context) -> Iterator[tuple[Place, str, str]]:
    """Place, name and text of each `set` of text such as `5 mm`."""
    for step, at in context.steps(Set):
        for name, value in step.set.items():
            if isinstance(value, str) and _is_quantity(value):
                yield (*at.place, "set", name), name, value


def items_like_quantities(context: Context) -> Iterator[tuple[str, str]]:
    """Name and items of each loop through texts such as `[5 mm, 1 cm]`, as one text."""
    for step, _ in context.steps(Foreach):
        for name, items in step.foreach.items():
            if isinstance(items, list) and all(
                isinstance(i, str) and _is_quantity(i) for i in items
            ):
                yield name, f"[{', '.join(items[:MOST])}{', ...' if items[MOST:] else ''}]"


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


def _left_over(text: Text) -> str:
    """What other languages end or begin a value with, where nothing else stands beside one expression."""
    beside = [part.strip() for part in text.parts if isinstance(part, str)]
    left = "".join(beside)
    return (
        left
        if len(text.parts) - len(beside) == 1 and left in ("=", ";", ",", ".", ":", "}", "{")
        else ""
    )


def _computed_with(context: Context) -> set[str]:
    """Names combined with something else in an expression that has no fault."""
    return {
        name
        for spot in context.survey.spots
        if not isinstance(spot.value, Exception) and not spot.inferred()[1]
        for one in spot.value.expressions()
        if not isinstance(one.tree.body, ast.Name)
        for name in one.names
    }
