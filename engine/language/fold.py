"""Values that are known before the run: parameters, constants, items of constant loops."""

import ast
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import islice, product
from typing import Any

from ...schemas.quantity import quantity_text
from .expression import Expression, ExpressionError
from .grid import Grid, Span
from .value import Value, as_text

MOST_ITEMS = 2000
MOST_CASES = 4000


@dataclass(frozen=True, slots=True)
class Folding:
    """The names with known values: parameters, `set` names, and loop names with their items."""

    params: Mapping[str, Any]
    names: Mapping[str, Any]
    loops: Mapping[str, Sequence[Any] | None]

    @property
    def given(self) -> dict[str, Any]:
        """What expressions are evaluated with, apart from the items of loops."""
        return {**self.names, "params": self.params}


@dataclass(frozen=True, slots=True)
class Folded:
    """The state of a value: known, dependent on known loops, or not known yet.

    `loops` are the loop names that it depends on; `fault` says why it cannot be computed.
    """

    known: bool
    value: Any = None
    loops: tuple[str, ...] = ()
    fault: str = ""


NOT_YET = Folded(known=False)


@dataclass(frozen=True, slots=True)
class Case:
    """One choice of items for the loops that a value depends on."""

    names: Mapping[str, Any]
    where: str = ""
    items: Mapping[str, Any] = field(default_factory=dict)


@lru_cache(maxsize=4096)
def needs(expression: Expression) -> tuple[frozenset[str], frozenset[str]] | None:
    """The parameters and other names that an expression needs; None where they are not fixed."""
    params: set[str] = set()
    owners = set()
    for node in ast.walk(expression.tree):
        if isinstance(node, ast.Attribute) and _is(node.value, "params"):
            params.add(node.attr)
            owners.add(id(node.value))
        elif (
            isinstance(node, ast.Subscript)
            and _is(node.value, "params")
            and isinstance(node.slice, ast.Constant)
        ):
            params.add(str(node.slice.value))
            owners.add(id(node.value))
    loose = any(
        _is(node, "params") and id(node) not in owners for node in ast.walk(expression.tree)
    )
    return None if loose else (frozenset(params), expression.names - {"params"})


def _is(node: ast.AST, name: str) -> bool:
    return isinstance(node, ast.Name) and node.id == name


def fold(value: Value | Exception, folding: Folding) -> Folded:
    """The value before the run, as far as it is known."""
    if isinstance(value, Exception):
        return NOT_YET
    loops: set[str] = set()
    for expression in value.expressions():
        if expression.live:
            return NOT_YET
        wanted = needs(expression)
        if wanted is None or not wanted[0] <= folding.params.keys():
            return NOT_YET
        for name in wanted[1]:
            if name in folding.loops:
                if folding.loops[name] is None:
                    return NOT_YET
                loops.add(name)
            elif name not in folding.names:
                return NOT_YET
    if loops:
        return Folded(known=True, loops=tuple(sorted(loops)))
    try:
        return Folded(known=True, value=value.evaluate(folding.given))
    except ExpressionError as fault:
        return Folded(known=False, fault=fault.reason)


def cases(folded: Folded, folding: Folding, value: Value) -> Iterator[Case]:
    """The combinations of loop items that decide whether a value is in range.

    Where the value is a sum of the items' fields, the outermost items decide; otherwise all items
    do, up to a limit.
    """
    base = folding.given
    if not folded.loops:
        yield Case(base)
        return
    straight = all(is_linear(one.tree.body, set(folded.loops)) for one in value.expressions())
    lists = [folding.loops[name] or () for name in folded.loops]
    choices = [outermost(items) if straight else everywhere(items) for items in lists]
    for picked in islice(product(*choices), MOST_CASES):
        items = {n: seq[i] for n, seq, i in zip(folded.loops, lists, picked, strict=True)}
        where = ", ".join(
            name_item(n, seq, i, items[n])
            for n, seq, i in zip(folded.loops, lists, picked, strict=True)
        )
        yield Case({**base, **items}, where, items)


def outermost(items: Sequence[Any]) -> list[int]:
    """The indices of items that include the minimum and maximum of every field."""
    if len(items) == 0:
        return []
    if isinstance(items, Grid):
        xs, ys = outermost(items.x), outermost(items.y)
        return sorted({items.index_of(ix, iy) for ix in xs for iy in ys})
    if isinstance(items, Span | range):
        return sorted({0, len(items) - 1})
    return everywhere(items)


def everywhere(items: Sequence[Any]) -> list[int]:
    """The indices of all items; for very long lists, an even selection with both ends."""
    count = len(items)
    if count <= MOST_ITEMS:
        return list(range(count))
    return sorted({*range(0, count, count // MOST_ITEMS + 1), count - 1, *_corners(items)})


def _corners(items: Sequence[Any]) -> list[int]:
    return items.corners() if isinstance(items, Grid) else []


def is_linear(node: ast.AST, loops: set[str]) -> bool:
    """True for sums of loop items and their fields, each multiplied by something constant."""
    if not _varies(node, loops):
        return True
    if isinstance(node, ast.Name):
        return True
    if isinstance(node, ast.Attribute):
        return isinstance(node.value, ast.Name)
    if isinstance(node, ast.UnaryOp):
        return is_linear(node.operand, loops)
    if isinstance(node, ast.BinOp):
        left, right = _varies(node.left, loops), _varies(node.right, loops)
        if isinstance(node.op, ast.Add | ast.Sub):
            return is_linear(node.left, loops) and is_linear(node.right, loops)
        if isinstance(node.op, ast.Mult) and not (left and right):
            return is_linear(node.left if left else node.right, loops)
        if isinstance(node.op, ast.Div) and not right:
            return is_linear(node.left, loops)
    return False


def _varies(node: ast.AST, loops: set[str]) -> bool:
    return any(isinstance(part, ast.Name) and part.id in loops for part in ast.walk(node))


def name_item(name: str, items: Sequence[Any], index: int, item: Any) -> str:
    """One item of a loop as messages name it: `grid point 1070 (4.2, 10.0)`."""
    if isinstance(items, Grid):
        x, y = (getattr(item[axis], "magnitude", item[axis]) for axis in ("x", "y"))
        return f"grid point {index} ({x}, {y})"
    shown = quantity_text(item) if hasattr(item, "units") else as_text(item)
    return f"{name} {shown if len(shown) < 40 else index}"
