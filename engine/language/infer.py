"""Infer the type of an expression before the run, and find what cannot work in it."""

import ast
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

from ...schemas.quantity import has_offset, same_dimension, unit_of
from .expression import CONSTANTS, TIMES, Expression, step_of
from .functions import LITERAL
from .infer_call import type_of_call
from .own_functions import OwnFunction
from .read_expression import as_written
from .suggest import closest, did_you_mean, listed
from .types import (
    ANY,
    BOOLEAN,
    INTEGER,
    MOMENT,
    NUMBER,
    TEXT,
    Type,
    either,
    in_words,
    number,
    type_of_value,
)  # fmt: skip

PLAIN_KINDS = {"boolean", "number", "text", "list", "map"}


@dataclass(frozen=True, slots=True)
class Fault:
    """What is wrong in an expression: a code and a message; `step`: of which step's result, if of one."""

    code: str
    message: str
    hint: str = ""
    step: str = ""


class Names(Protocol):
    """The context of an expression: the types of the names that it may use."""

    def name(self, name: str) -> Type | Fault:
        """The type of a name, or why there is none."""
        ...

    def param(self, name: str) -> Type | Fault:
        """The type of `params.name`."""
        ...

    def step(self, name: str) -> Type | Fault:
        """The type of `steps.name`."""
        ...

    def function(self, name: str) -> OwnFunction | None:
        """The protocol's own function of this name, if it can be used."""
        ...

    def table(self, file: str, kinds: Mapping[str, str]) -> Type | Fault:
        """The type of `csv(file, column='kind', ...)`."""
        ...


def infer(expression: Expression, names: Names) -> tuple[Type, list[Fault]]:
    """The type of an expression's value, and everything in it that cannot work."""
    inference = Inference(names, expression.calls)
    found = inference.of(expression.tree.body)
    return found, inference.faults


class Inference:
    """One walk over one expression; a faulty part gets the type ANY, so that the rest is checked."""

    def __init__(self, names: Names, calls: frozenset[str] = frozenset()) -> None:
        self.names, self.calls = names, calls
        self._own: dict[str, Type] = {}  # names of the comprehensions around
        self.faults: list[Fault] = []

    def fault(self, code: str, message: str, hint: str = "") -> Type:
        """Record a fault; the part's type is then unknown."""
        self.faults.append(Fault(code, message, hint))
        return ANY

    def noted(self, found: Type | Fault) -> Type:
        """Pass a type through; record a fault."""
        if isinstance(found, Fault):
            self.faults.append(found)
            return ANY
        return found

    def of(self, node: ast.AST) -> Type:
        """The type of a part."""
        return getattr(self, f"_{type(node).__name__.lower()}", self._unknown)(node)

    def _unknown(self, node: ast.AST) -> Type:
        return ANY

    def _constant(self, node: ast.Constant) -> Type:
        return type_of_value(node.value)

    def _listcomp(self, node: ast.ListComp | ast.GeneratorExp) -> Type:
        around = self._own
        for part in node.generators:
            items = self.of(part.iter)
            if items.kind not in ("list", "any", "null"):
                self.fault("E308", f"{as_written(part.iter)} is {in_words(items)}, not a list")
            item = items.item or ANY
            targets = part.target.elts if isinstance(part.target, ast.Tuple) else []
            own = {one.id: item.item or ANY for one in targets if isinstance(one, ast.Name)}
            if isinstance(part.target, ast.Name):
                own = {part.target.id: item}
            self._own = {**self._own, **own}
            for condition in part.ifs:
                self.of(condition)
        found = Type("list", item=self.of(node.elt))
        self._own = around
        return found

    _generatorexp = _listcomp

    def _name(self, node: ast.Name) -> Type:
        if node.id in self._own:
            return self._own[node.id]
        if node.id in CONSTANTS:
            return type_of_value(CONSTANTS[node.id])
        if node.id in ("params", "steps"):
            return self.fault("E302", f"{node.id} is not a value; write {node.id}.NAME")
        return self.noted(self.names.name(node.id))

    def _attribute(self, node: ast.Attribute) -> Type:
        if isinstance(node.value, ast.Name):
            if node.value.id == "params":
                return self.noted(self.names.param(node.attr))
            if node.value.id == "steps":
                return self.noted(self.names.step(node.attr))
        before = len(self.faults)
        owner = self.of(node.value)
        if len(self.faults) > before:
            self._say_what_has_it(node, self.faults[-1])
        return self._field(owner, node.attr, node)

    def _say_what_has_it(self, node: ast.Attribute, fault: Fault) -> None:
        """`steps.a.outputs.mass`, or `env.pitch`: what is written without the part that is not there."""
        hint = ""
        if isinstance(node.value, ast.Name) and fault.hint.startswith("text needs quotes"):
            many = f"{node.value.id}s"
            hint = (
                f"write {many}.{node.attr}"
                if many in ("params", "steps")
                else f"a parameter is params.{node.attr}, and what a step returned steps.ID.{node.attr}"
            )
        elif (
            isinstance(node.value, ast.Attribute)
            and fault.code == "E301"
            and node.attr in self.of(node.value.value).fields
        ):
            hint = f"write {ast.unparse(node.value.value)}.{node.attr}"
        if hint:
            self.faults[-1] = replace(fault, hint=hint)

    def _field(self, owner: Type, name: str, node: ast.Attribute | ast.Subscript) -> Type:
        if name in TIMES and isinstance(node, ast.Attribute) and step_of(node.value) is not None:
            own = owner.fields.get(name)
            if own is None and owner.rest is None and owner.kind != "any":
                return MOMENT if name == "started" else number("s")
        if owner.kind in ("any", "null"):
            return ANY
        whole, what = ast.unparse(node.value), _called(node.value)
        if owner.kind != "map":
            return self.fault(
                "E301", f"{whole}.{name}: {what} is {in_words(owner)} and has no fields"
            )
        if name in owner.meant:
            words = f"one of the items has {owner.meant[name]} instead of {name}"
            return self.fault("E301", f"{whole}.{name}: {words}")
        if name in owner.fields:
            return owner.fields[name]
        if owner.rest is not None:
            return owner.rest
        verb = "returns" if what.startswith("'") else "has"
        times = TIMES if step_of(node.value) is not None else ()
        near = closest(name, [*owner.fields, *times])
        guess = f"; did you mean {whole}.{near}?" if near else ""
        known = listed(owner.fields) if owner.fields else "nothing"
        return self.fault("E301", f"{whole}.{name}: {what} {verb} {known}{guess}")

    def _subscript(self, node: ast.Subscript) -> Type:
        if isinstance(node.value, ast.Name) and isinstance(node.slice, ast.Constant):
            key = str(node.slice.value)
            if node.value.id == "params":
                return self.noted(self.names.param(key))
            if node.value.id == "steps":
                return self.noted(self.names.step(key))
        owner, index = self.of(node.value), node.slice
        if isinstance(index, ast.Slice):
            for part in (index.lower, index.upper, index.step):
                if part is not None:
                    self.of(part)
            return owner
        self.of(index)
        if owner.kind == "list":
            return owner.item or ANY
        if owner.kind == "map":
            if isinstance(index, ast.Constant) and isinstance(index.value, str):
                return self._field(owner, index.value, node)
            return ANY
        if owner.kind in ("number", "boolean"):
            return self.fault(
                "E308", f"{as_written(node.value)} is {in_words(owner)} and has no items"
            )
        return TEXT if owner.kind == "text" else ANY

    def _list(self, node: ast.List | ast.Tuple) -> Type:
        return Type("list", item=either([self.of(item) for item in node.elts]))

    _tuple = _list

    # --- operators

    def _unaryop(self, node: ast.UnaryOp) -> Type:
        operand = self.of(node.operand)
        if isinstance(node.op, ast.Not):
            return BOOLEAN
        if operand.kind not in ("any", "null", "number"):
            return self.fault(
                "E308", f"{as_written(node.operand)} is {in_words(operand)}, not a number"
            )
        return operand if self._steady(node.operand, operand) else ANY

    def _boolop(self, node: ast.BoolOp) -> Type:
        types = [self.of(value) for value in node.values]
        for index, (value, kind) in enumerate(zip(node.values, types, strict=True)):
            before = node.values[index - 1]
            if index and kind.kind in ("number", "text") and _is_literal(value):
                if not isinstance(before, ast.Compare):
                    continue  # `x or 5 mm`, for an x that may be null
                whole = ast.Compare(before.left, before.ops[:1], [value])
                word = "or" if isinstance(node.op, ast.Or) else "and"
                message = f"{as_written(value)} alone is no condition"
                self.fault(
                    "E308", message, f"write {as_written(before)} {word} {as_written(whole)}"
                )
        return either(types)

    def _ifexp(self, node: ast.IfExp) -> Type:
        self.of(node.test)
        return either([self.of(node.body), self.of(node.orelse)])

    def _compare(self, node: ast.Compare) -> Type:
        sides = [node.left, *node.comparators]
        types = [self.of(side) for side in sides]
        for index, operator in enumerate(node.ops):
            if not isinstance(operator, ast.In | ast.NotIn):
                self._compared(sides[index], types[index], sides[index + 1], types[index + 1])
            elif isinstance(within := sides[index + 1], ast.List | ast.Tuple):
                for one in within.elts:
                    self._one_of_its_choices(sides[index], types[index], one)
        return BOOLEAN

    def _compared(self, a: ast.AST, left: Type, b: ast.AST, right: Type) -> None:
        kinds, hint = {left.kind, right.kind}, None
        if kinds == {"number", "text"}:
            text, other = (a, right) if left.kind == "text" else (b, left)
            if isinstance(text, ast.Name):
                return  # what a `set` gave it is judged there (W420)
            bare = isinstance(text, ast.Constant) and other.unit is not None
            hint = f"write {text.value} without quotes" if bare else ""  # type: ignore[attr-defined]
        elif "moment" in kinds and kinds - {"moment", "any", "null"}:
            hint = "the time between two moments is their difference; elapsed() is that since the start"
        elif len(kinds) == 2 and kinds <= PLAIN_KINDS and kinds & {"map", "list", "text"}:
            node, one = (a, left) if left.kind in ("map", "list") else (b, right)
            hint = f"such as {as_written(node)}.{next(iter(one.fields))}" if one.fields else ""
        if hint is not None:
            message = (
                f"{as_written(a)} is {in_words(left)} and {as_written(b)} is {in_words(right)}"
            )
            self.fault("E308", f"{message}; they cannot be compared", hint)
            return
        for (node, one), (asked, other) in (((a, left), (b, right)), ((b, right), (a, left))):
            self._one_of_its_choices(node, one, asked)
            if one.difference and other.unit is not None and has_offset(other.unit):
                message = f"{as_written(node)} is a difference, and {as_written(asked)} a place on a scale"
                self.fault("E308", message, "give a difference of temperatures in K, such as 1 K")
        self.go_together(a, left, b, right, "compared")

    def _one_of_its_choices(self, node: ast.AST, one: Type, asked: ast.AST) -> None:
        """A text that has choices is compared with one of them, or with null."""
        if not one.choices or not isinstance(asked, ast.Constant):
            return
        if asked.value is not None and asked.value not in one.choices:
            guess = did_you_mean(str(asked.value), one.choices)
            message = f"{as_written(node)} is never {asked.value!r}{guess}"
            self.fault("E308", message, f"it is one of {listed(one.choices)}")

    def _binop(self, node: ast.BinOp) -> Type:
        left, right = self.of(node.left), self.of(node.right)
        if "any" in (left.kind, right.kind) or "null" in (left.kind, right.kind):
            return ANY
        if (
            left.kind == right.kind
            and left.kind in ("text", "list")
            and isinstance(node.op, ast.Add)
        ):
            return left
        if "moment" in (left.kind, right.kind):
            return self._moments(node, left, right)
        if not left.kind == right.kind == "number":
            return self._not_numbers(node, left, right)
        if _scales(left, right) and isinstance(node.op, ast.Add | ast.Sub):
            return self._temperatures(node, left, right)
        if not (self._steady(node.left, left) and self._steady(node.right, right)):
            return ANY
        if isinstance(node.op, ast.Mult | ast.Div):
            return self._product(left, right, divide=isinstance(node.op, ast.Div))
        if isinstance(node.op, ast.Pow):
            return self._power(node, left, right)
        verb = {ast.Add: "added", ast.Sub: "subtracted"}.get(type(node.op), "divided")
        if not self.go_together(node.left, left, node.right, right, verb):
            return ANY
        if isinstance(node.op, ast.FloorDiv):
            return NUMBER
        kept = right if left.unit is None else left
        return Type("number", kept.unit, whole=left.whole and right.whole and kept.unit is None)

    def _moments(self, node: ast.BinOp, left: Type, right: Type) -> Type:
        """The time between two moments; a moment some time later or earlier."""
        less = isinstance(node.op, ast.Sub)
        if less and left.kind == right.kind:
            return number("s")
        by = right if left.kind == "moment" else left
        a_time = by.kind == "number" and (
            by.zero or (by.unit is not None and same_dimension(by.unit, "s"))
        )
        if a_time and (isinstance(node.op, ast.Add) or (less and left.kind == "moment")):
            return MOMENT
        ours = f"{as_written(node.left)} is {in_words(left)}"
        message = f"{ours} and {as_written(node.right)} is {in_words(right)}"
        hint = "two moments may be subtracted, and a time such as 5 min be added to one"
        return self.fault("E308", f"{message}; they cannot be combined", hint)

    def _steady(self, node: ast.AST, one: Type) -> bool:
        if one.unit is None or not has_offset(one.unit):
            return True
        message = f"{as_written(node)} is in {one.unit}, whose zero is arbitrary"
        self.fault("E308", message, "compute in K; a difference of temperatures is in K, too")
        return False

    def _temperatures(self, node: ast.BinOp, left: Type, right: Type) -> Type:
        """degC less degC is a difference in K; degC and K, added or subtracted, are degC."""
        if not self.go_together(node.left, left, node.right, right, "combined"):
            return ANY
        offset = [one.unit is not None and has_offset(one.unit) for one in (left, right)]
        less = isinstance(node.op, ast.Sub)
        if all(offset):
            if less:
                return Type("number", "K", difference=True)
            message = f"{as_written(node)}: two places on a scale cannot be added"
            return self.fault("E308", message, "add a difference in K")
        if less and not offset[0] and left.unit is not None:
            return self.fault(
                "E308", f"{as_written(node)}: K less degC", "give both in degC, or both in K"
            )
        return left if offset[0] else right

    def _not_numbers(self, node: ast.BinOp, left: Type, right: Type) -> Type:
        wrong, side = (left, node.left) if left.kind != "number" else (right, node.right)
        hint = (
            "" if "text" not in (left.kind, right.kind) else "insert values into text with ${{ }}"
        )
        return self.fault("E308", f"{as_written(side)} is {in_words(wrong)}, not a number", hint)

    def go_together(self, a: ast.AST, left: Type, b: ast.AST, right: Type, verb: str) -> bool:
        """True where two numbers have units of one dimension; records a fault where not."""
        if not left.kind == right.kind == "number" or left.unit == right.unit:
            return True
        if (left.unit is None and left.zero) or (right.unit is None and right.zero):
            return True
        if left.unit and right.unit and same_dimension(left.unit, right.unit):
            return True
        message = (
            f"{as_written(a)} is {in_words(left)} and {as_written(b)} is {in_words(right)}; "
            f"they cannot be {verb}"
        )
        unit = left.unit or right.unit
        hint = "" if left.unit and right.unit else f"give the other a unit, such as 1 {unit}"
        self.fault("E308", message, hint)
        return False

    def _product(self, left: Type, right: Type, *, divide: bool) -> Type:
        if left.unit is None and right.unit is None:
            return INTEGER if left.whole and right.whole and not divide else NUMBER
        if right.unit is None:
            return replace(number(left.unit), difference=left.difference)
        if left.unit is None and not divide:
            return replace(number(right.unit), difference=right.difference)
        first, second = unit_of(left.unit or ""), unit_of(right.unit)
        unit = first / second if divide else first * second
        return NUMBER if unit.dimensionless else number(str(unit))

    def _power(self, node: ast.BinOp, left: Type, right: Type) -> Type:
        if right.unit is not None:
            return self.fault(
                "E308", f"{as_written(node.right)} is {in_words(right)}; an exponent has no unit"
            )
        if left.unit is None:
            return NUMBER
        if isinstance(node.right, ast.Constant) and isinstance(node.right.value, int | float):
            return number(str(unit_of(left.unit) ** node.right.value))
        return ANY

    def _call(self, node: ast.Call) -> Type:
        return type_of_call(self, node)


def _scales(*types: Type) -> bool:
    return any(one.unit is not None and has_offset(one.unit) for one in types)


def _is_literal(node: ast.AST) -> bool:
    """Whether it is a number, a text or a quantity as it is written."""
    called = node.func if isinstance(node, ast.Call) else None
    if isinstance(called, ast.Name) and called.id == LITERAL:
        return True
    return isinstance(node, ast.Constant) and not isinstance(node.value, bool | None)


def _called(node: ast.AST) -> str:
    """How messages name the owner of a field: a step by its id, anything else as written."""
    if (
        isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Name)
        and node.value.id == "steps"
    ):
        return f"'{node.attr}'"
    return as_written(node)
