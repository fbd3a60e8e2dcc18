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

from ...schemas.problem import Problem
from ..language.expression import ExpressionError
from ..language.fold import MOST_ITEMS, Folding, fold, name_item
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
    if loop.name not in value.names and not (loop.items is not None and len(loop.items) < 2):
        message = f"this key is the same in every iteration: it does not use {loop.name}"
        yield context.source.problem(spot.place, "E404", message, f"such as ${{{{ {loop.name} }}}}")
        return
    double = first_double(value, loop, spot.env.folding())
    if double is not None:
        which, key, what = double
        message = f"{which} have the same key {key!r} ({what})"
        yield context.source.problem(
            spot.place, "E404", message, "use something that differs between them"
        )


def _surely_different(value: Value, loop: LoopName) -> bool:
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


def first_double(value: Value, loop: LoopName, folding: Folding) -> tuple[str, str, str] | None:
    """Two iterations for which a value is the same text: which, the text, and their items.

    None where there are none, and where it is not known before the run.
    """
    items, folded = loop.items, fold(value, folding)
    if items is None or len(items) > MOST_ITEMS or _surely_different(value, loop):
        return None
    if not folded.known or len(folded.loops) > 1:
        return None
    seen: dict[str, int] = {}
    for index, item in enumerate(items):
        try:
            text = as_text(value.evaluate({**folding.given, loop.name: item}))
        except ExpressionError:
            return None  # reported by the family `calculations`
        first = seen.setdefault(text, index)
        if first != index:
            what = ", ".join(name_item(loop.name, items, n, items[n]) for n in (first, index))
            return f"iterations {first} and {index}", text, what
    return None
