"""Values and expressions in words: known ones as values, the rest as `the point's x`."""

import ast
from typing import Any

from ....schemas.quantity import is_quantity, quantity_text
from ...language.expression import STATUS, TIMES, Expression, ExpressionError
from ...language.functions import CLOCKS, LITERAL
from ...language.shape import Place
from ...language.types import LOOP_RESULT
from ...language.value import Computed, Text, as_text, value_of
from ..english import bare, count_of, joined, shortened
from ..forecast import UNKNOWN, Outlook

COMPARED = {
    ast.Eq: "is", ast.NotEq: "is not", ast.Lt: "is less than", ast.LtE: "is at most",
    ast.Gt: "is more than", ast.GtE: "is at least", ast.In: "is among", ast.NotIn: "is not among",
}  # fmt: skip
SIGNS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "×", ast.Div: "/", ast.Pow: "^", ast.Mod: "modulo"}
SIMULATED = "the run is {}simulated"
OF_LOOPS = {
    "total": "the number of turns of", "succeeded": "the number of turns that succeeded of",
    "failed": "the number of turns that failed of", "skipped": "the number of turns left out of",
}  # fmt: skip


def spoken(view: Outlook, raw: Any, place: Place) -> str:
    """The value at a place of a protocol, in words."""
    value = view.value(raw, place)
    if value is not UNKNOWN:
        return said(value)
    try:
        written = value_of(raw, view.survey.own_names)
    except ExpressionError:
        return str(raw)
    if isinstance(written, Computed):
        return Speech(view).of(written.expression)
    if isinstance(written, Text):
        return "".join(_part(view, part) for part in written.parts)
    if isinstance(raw, list):
        return f"the list of {joined([spoken(view, item, place) for item in raw])}"
    if isinstance(raw, dict):
        return _pairs({key: (item, spoken(view, item, place)) for key, item in raw.items()})
    return said(raw)


def condition(view: Outlook, raw: Any, place: Place) -> str:
    """What a step's `when`, `if`, `while` or `require` asks, whether or not its value is known."""
    try:
        written = value_of(raw, view.survey.own_names)
    except ExpressionError:
        return bare(raw)
    speech = Speech(view, named=True)
    return speech.of(written.expression) if isinstance(written, Computed) else bare(raw)


def said(value: Any) -> str:
    """A value as part of a sentence."""
    if isinstance(value, str):
        return value
    if isinstance(value, dict):
        return _pairs({key: (item, said(item)) for key, item in value.items()})
    if value == []:
        return "an empty list"
    if isinstance(value, list) and any(isinstance(item, dict | list) for item in value):
        return f"a list of {count_of(len(value), 'item')}"
    return quantity_text(value) if is_quantity(value) else as_text(value)


def _pairs(items: dict[str, tuple[Any, str]]) -> str:
    """`minimum = 0, maximum = 100`; what holds more in brackets: `red (minimum = 0)`."""
    shown = [
        f"{key} ({words})" if isinstance(item, dict) else f"{key} = {words}"
        for key, (item, words) in items.items()
    ]
    return ", ".join(shown)


def _part(view: Outlook, part: str | Expression) -> str:
    if isinstance(part, str):
        return part
    try:
        return as_text(part.evaluate(view.names))
    except ExpressionError:
        words = Speech(view).of(part).removeprefix("the ")
        return f"({words.strip('`')})"  # `(point's x)`; `(sample)`, a parameter without a value yet


class Speech:
    """Puts the syntax tree of an expression into words; `named`: parameters by name as well as value."""

    def __init__(self, view: Outlook, *, named: bool = False) -> None:
        self.view = view
        self.named = named

    def of(self, expression: Expression) -> str:
        """An expression, or its own text if words would be longer."""
        words = self._node(expression.tree.body)
        return words if words else f"`{shortened(expression.text)}`"

    def _node(self, node: ast.AST) -> str:
        """The words of a part, empty if there are none for it."""
        if isinstance(node, ast.Constant):
            return f"{node.value!r}" if isinstance(node.value, str) else as_text(node.value)
        if isinstance(node, ast.Name):
            return self._name(node.id)
        if isinstance(node, ast.Attribute):
            return self._field(node)
        if isinstance(node, ast.BinOp):
            return self._sum(node)
        if isinstance(node, ast.Compare) and len(node.ops) == 1:
            left, right = self._node(node.left), self._node(node.comparators[0])
            verb = COMPARED.get(type(node.ops[0]))
            return f"{left} {verb} {right}" if left and right and verb else ""
        if isinstance(node, ast.BoolOp):
            parts = [self._node(value) for value in node.values]
            return (
                joined(parts, "and" if isinstance(node.op, ast.And) else "or") if all(parts) else ""
            )
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return self._not(node.operand)
        return self._literal(node)

    def _not(self, node: ast.AST) -> str:
        inner = self._node(node)
        if inner == SIMULATED.format(""):
            return SIMULATED.format("not ")
        return f"not {inner}" if inner else ""

    def _literal(self, node: ast.AST) -> str:
        """`0.1 mm`, which is read as a call."""
        if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Name):
            return ""
        if node.func.id in CLOCKS:
            return {"now": "the time of day"}.get(node.func.id, "the time since the start")
        values = [one.value for one in node.args if isinstance(one, ast.Constant)]
        return f"{values[0]} {values[1]}" if node.func.id == LITERAL and len(values) == 2 else ""

    def _name(self, name: str) -> str:
        if name in self.view.names:
            return said(self.view.names[name])
        items = any(loop.name == name for loop in self.view.survey.loops)
        return f"the {name}" if items and len(name) > 1 else name

    def _field(self, node: ast.Attribute) -> str:
        owner = node.value
        if isinstance(owner, ast.Name):
            if owner.id == "params":
                return self._param(node.attr)
            if owner.id == "steps":
                return f"the result of {node.attr!r}"
            if owner.id == "run":
                return (
                    SIMULATED.format("") if node.attr == "simulated" else f"the run's {node.attr}"
                )
            if owner.id in self.view.names:
                known = self.view.names[owner.id]
                return (
                    said(known[node.attr]) if isinstance(known, dict) and node.attr in known else ""
                )
            return f"{self._name(owner.id)}'s {node.attr}"
        if isinstance(owner, ast.Attribute) and ast.unparse(owner.value) == "steps":
            return self._result(owner.attr, node.attr)
        if isinstance(owner, ast.Attribute) and ast.unparse(owner.value) == STATUS:
            return f"the {owner.attr}'s {node.attr}"
        inner = self._node(owner)
        return f"{node.attr} in {inner}" if inner else ""

    def _param(self, name: str) -> str:
        known = self.view.names["params"]
        if name not in known:
            return name
        return f"{name} ({said(known[name])})" if self.named else said(known[name])

    def _result(self, step: str, field: str) -> str:
        declared = self.view.survey.ids.get(step)
        if declared is not None and declared.type == LOOP_RESULT and field in OF_LOOPS:
            return f"{OF_LOOPS[field]} {step!r}"
        if field in TIMES and declared is not None and field not in declared.type.fields:
            return f"the {'beginning' if field == 'started' else 'duration'} of {step!r}"
        return f"the {field} of {step!r}"

    def _sum(self, node: ast.BinOp) -> str:
        left, right, sign = self._node(node.left), self._node(node.right), SIGNS.get(type(node.op))
        if not left or not right or sign is None:
            return ""
        if sign == "+" and left.split(" ")[0] == "0":
            return right
        if sign in "+-" and right.split(" ")[0] == "0":
            return left
        return f"{left} {sign} {right}"
