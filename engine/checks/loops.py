"""The key of an iteration identifies it permanently: `labrun resume` relies on it.

E404. No two iterations of a loop may have the same key: after a crash one would be taken for
finished because the other is. Where the items are known before the run, every key is computed
and compared.

Passes:

    devices: {balance: balance@1}
    steps:
      - foreach: {vial: [A, B, C]}
        key: ${{ vial }}
        steps:
          - do: balance.weigh

Fails:

    devices: {balance: balance@1}
    steps:
      - foreach: {vial: [A, B, A]}
        key: ${{ vial }}
        steps:
          - do: balance.weigh

W404. A loop without items does nothing. Often its list was emptied for a test.

Passes:

    devices: {balance: balance@1}
    steps:
      - repeat: 3
        steps:
          - do: balance.weigh

Fails:

    devices: {balance: balance@1}
    steps:
      - repeat: 0
        steps:
          - do: balance.weigh
"""

import ast
from collections.abc import Iterator, Sequence
from typing import Any

from ...schemas.problem import Problem
from ..language.expression import ExpressionError
from ..language.fold import MOST_ITEMS, fold, name_item
from ..language.grid import Grid
from ..language.value import Computed, Text, Value, as_text
from ..survey.scope import LoopName
from ..survey.spots import Spot
from .context import Context

CODES = {
    "E404": "two iterations with the same key",
    "W404": "a loop without items",
}


def check(context: Context) -> Iterator[Problem]:
    """Every loop."""
    for spot in context.survey.spots:
        if isinstance(spot.value, Exception) or spot.inferred()[1]:
            continue
        if spot.use == "key":
            yield from _keys(context, spot, spot.env.loops[-1])
        elif spot.use == "items" or spot.what == "repeat":
            yield from _empty(context, spot)


def _empty(context: Context, spot: Spot) -> Iterator[Problem]:
    folded = fold(spot.value, spot.env.folding())
    if not folded.known or folded.loops:
        return
    is_list = isinstance(folded.value, Sequence) and not isinstance(folded.value, str)
    if (is_list and len(folded.value) == 0) or (folded.value == 0 and spot.what == "repeat"):
        message = "this loop has no items: its steps never run"
        yield context.source.problem(spot.place, "W404", message)


def _keys(context: Context, spot: Spot, loop: LoopName) -> Iterator[Problem]:
    value = spot.value
    assert isinstance(value, Value)
    used = {name for one in value.expressions() for name in one.names}
    if loop.name not in used and not (loop.items is not None and len(loop.items) < 2):
        message = f"this key is the same in every iteration: it does not use {loop.name}"
        yield context.source.problem(spot.place, "E404", message, f"such as ${{{{ {loop.name} }}}}")
        return
    items = loop.items
    if items is None or len(items) > MOST_ITEMS or surely_different(value, loop):
        return
    folding = spot.env.folding()
    if not fold(value, folding).known or len(fold(value, folding).loops) > 1:
        return
    double = first_double(value, items, loop.name, {**folding.names, "params": folding.params})
    if double is not None:
        first, second, key = double
        what = [name_item(loop.name, items, index, items[index]) for index in (first, second)]
        message = (
            f"iterations {first} and {second} have the same key {key!r} ({what[0]}, {what[1]})"
        )
        yield context.source.problem(
            spot.place, "E404", message, "use something that differs between them"
        )


def surely_different(value: Value, loop: LoopName) -> bool:
    """True for `${{ p.index }}`, and for a grid's `${{ p.ix }},${{ p.iy }}`: no need to compute."""
    parts = (
        value.parts
        if isinstance(value, Text)
        else [value.expression]
        if isinstance(value, Computed)
        else []
    )
    read = set()
    for part in parts:
        node = part.tree.body if not isinstance(part, str) else None
        if (
            isinstance(node, ast.Attribute)
            and isinstance(node.value, ast.Name)
            and node.value.id == loop.name
        ):
            read.add(node.attr)
    texts = [part for part in parts if isinstance(part, str)]
    apart = len(parts) == 3 and len(texts) == 1 and not texts[0].isdigit()
    return isinstance(loop.items, Grid) and (read == {"index"} or (read == {"ix", "iy"} and apart))


def first_double(
    value: Value, items: Sequence[Any], name: str, names: dict[str, Any]
) -> tuple[int, int, str] | None:
    seen: dict[str, int] = {}
    for index, item in enumerate(items):
        try:
            key = as_text(value.evaluate({**names, name: item}))
        except ExpressionError:
            return None  # reported by the family `calculations`
        if key in seen:
            return seen[key], index, key
        seen[key] = index
    return None
