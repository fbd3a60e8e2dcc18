"""One expression of a protocol: read once, checked for what it may contain, evaluated often.

It is Python's syntax without side effects: no assignments, calls only of the functions in
`functions.py`, `a.b` reads a field and nothing else. `0.1 mm` is a quantity.
"""

import ast
import math
from collections import ChainMap
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import count
from typing import TYPE_CHECKING, Any

from ...schemas.quantity import is_number, is_quantity
from .functions import CLOCKS, FUNCTIONS, LITERAL, literal
from .operators import OPERATORS, words
from .read_expression import CONSTANTS, ExpressionError, names_in, parse
from .suggest import did_you_mean

if TYPE_CHECKING:
    from simpleeval import SimpleEval

MOST_TURNS = 100_000
"""Of a comprehension; more would hold up the run."""
TIMES = ("started", "took")
"""What every step has besides its result; a result's own field of that name wins."""
STATUS = "status"
"""What devices say of themselves: `status.ROLE.FIELD`."""
PUBLIC = {function.__name__: name for name, function in FUNCTIONS.items()}


class Pending(Exception):
    """A value that is being computed elsewhere: the expression is to be evaluated again later."""


class Expression:
    """One expression; `names` are the names that it uses, without functions.

    `live`: it asks a clock, reads a status or calls a function of the protocol's own, so that only a run can
    compute it. `calls`: the latter.
    """

    __slots__ = ("_evaluator", "calls", "live", "names", "text", "tree")

    def __init__(self, text: str, own: frozenset[str] = frozenset()) -> None:
        self.text = text.strip()
        self.tree = parse(self.text, own)
        self.names = frozenset(names_in(self.tree))
        called = {
            node.func.id  # type: ignore[attr-defined]
            for node in ast.walk(self.tree)
            if isinstance(node, ast.Call)
        }
        self.calls = frozenset(called & own)
        self.live = bool(self.calls or called & CLOCKS.keys() or STATUS in self.names)
        self._evaluator: SimpleEval | None = None

    def evaluate(self, names: Mapping[str, Any]) -> Any:
        """The value for these names; raises ExpressionError."""
        evaluator = self._evaluator = self._evaluator or _evaluator(self.calls)
        evaluator.names = names  # type: ignore[assignment]  # a Mapping is all it reads
        try:
            return _finite(evaluator._eval(self.tree.body))
        except Pending:
            raise
        except ExpressionError as fault:
            raise ExpressionError(fault.reason, self.text) from fault
        except Exception as fault:  # wrong values make pint and operators raise of many kinds
            raise ExpressionError(_sentence(fault), self.text) from fault

    def __repr__(self) -> str:
        return f"Expression({self.text!r})"


@lru_cache(maxsize=4096)
def expression(text: str, own: frozenset[str] = frozenset()) -> Expression:
    """The expression of a text, cached."""
    return Expression(text, own)


def field_of(value: Any, name: str, *, lenient: bool) -> Any:
    """`value.name`; null if the value is null, or a result without the field."""
    if value is None:
        return None
    if not isinstance(value, Mapping):
        raise ExpressionError(f"{words(value)} has no field {name}")
    if name in value:
        return value[name]
    if lenient:
        return None
    raise ExpressionError(f"there is no field {name}{did_you_mean(name, value)}")


def item_of(value: Any, index: Any, *, lenient: bool) -> Any:
    """`value[index]`; null if the value is null."""
    if value is None:
        return None
    if isinstance(value, Mapping):
        return field_of(value, str(index), lenient=lenient)
    if is_quantity(value) or not isinstance(value, Sequence):
        raise ExpressionError(f"{words(value)} has no items")
    if not isinstance(index, int | slice) or isinstance(index, bool):
        raise ExpressionError(f"an item is selected by a whole number, not {words(index)}")
    try:
        return value[index]
    except IndexError as fault:
        raise ExpressionError(f"there is no item {index} of {len(value)}") from fault


def step_of(node: ast.expr) -> str | None:
    """ID where the node is `steps.ID`, or `steps['ID']`."""
    if not isinstance(node, ast.Attribute | ast.Subscript):
        return None
    if not isinstance(node.value, ast.Name) or node.value.id != "steps":
        return None
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.slice.value if isinstance(node.slice, ast.Constant) else None  # type: ignore


def told_steps(expression: Expression) -> set[str | None]:
    """The steps of which an expression reads anything; None among them where it may be any."""
    nodes = list(ast.walk(expression.tree))
    steps = [node for node in nodes if isinstance(node, ast.Name) and node.id == "steps"]
    within = [n for n in nodes if isinstance(n, ast.Attribute | ast.Subscript) and n.value in steps]
    return {*map(step_of, within), *([None] if len(within) < len(steps) else [])}


def timed_steps(expression: Expression) -> set[str]:
    """The steps of which an expression asks when they began, or how long they took."""
    return {
        step
        for node in ast.walk(expression.tree)
        if isinstance(node, ast.Attribute) and node.attr in TIMES
        if (step := step_of(node.value)) is not None
    }


def told_roles(expression: Expression, roles: Collection[str]) -> set[str]:
    """Of these roles, those whose `status` an expression reads."""
    nodes = list(ast.walk(expression.tree))
    status = [node for node in nodes if isinstance(node, ast.Name) and node.id == STATUS]
    asked = [
        node.attr if isinstance(node, ast.Attribute) else getattr(node.slice, "value", None)
        for node in nodes
        if isinstance(node, ast.Attribute | ast.Subscript) and node.value in status
    ]
    if len(asked) < len(status) or not set(asked) <= set(roles):
        return set(roles)  # chosen in the run, or `status` as a whole
    return {role for role in roles if role in asked}


def in_answer(node: ast.expr) -> bool:
    """True for a step's result and anything inside it: `steps.ID` and deeper."""
    depth = 0
    while isinstance(node, ast.Attribute | ast.Subscript):
        node, depth = node.value, depth + 1
    return isinstance(node, ast.Name) and node.id == "steps" and depth >= 1


def _evaluator(own: frozenset[str]) -> "SimpleEval":
    functions = {**FUNCTIONS, LITERAL: literal, **{name: _only_in_a_run(name) for name in own}}
    made = _evaluator_class()(operators=OPERATORS, functions=functions)
    made.named = {name: functions[name] for name in (*CLOCKS, *own)}  # type: ignore[attr-defined]
    return made


def _only_in_a_run(name: str) -> Callable[..., Any]:
    def refuse(*args: Any, **kwargs: Any) -> Any:
        raise ExpressionError(f"{name}: it is only called in a run")

    return refuse


@lru_cache(maxsize=1)
def _evaluator_class() -> "type[SimpleEval]":
    """simpleeval's evaluator, narrowed: fields and items of plain data, lists, no attributes."""
    import simpleeval

    class Evaluator(simpleeval.SimpleEval):
        def __init__(self, **given: Any) -> None:
            super().__init__(**given)
            self.named: dict[str, Callable[..., Any]] = {}
            nodes: Any = self.nodes
            nodes[ast.List] = nodes[ast.Tuple] = self._eval_list
            nodes[ast.ListComp] = nodes[ast.GeneratorExp] = self._eval_comprehension

        def _check_disallowed_items(self, item: Any) -> None:
            """Nothing to check: names hold only data, and functions are never values."""

        def _eval_list(self, node: Any) -> list[Any]:
            return [self._eval(item) for item in node.elts]

        def _eval_comprehension(self, node: Any) -> list[Any]:
            outer, found = self.names, []
            try:
                for own in self._bindings(node.generators, outer, count(1)):
                    self.names = own
                    found.append(self._eval(node.elt))
            finally:
                self.names = outer
            return found

        def _bindings(self, generators: Any, names: Any, turns: Iterator[int]) -> Iterator[Any]:
            """The names at each turn of `for ... in ... if ...`, one within the other."""
            if not generators:
                yield names
                return
            first, *inner = generators
            self.names = names
            for item in _items(self._eval(first.iter)):
                if next(turns) > MOST_TURNS:
                    raise ExpressionError(f"a comprehension of more than {MOST_TURNS:,} turns")
                own = ChainMap(_bound(first.target, item), names)
                self.names = own  # type: ignore[assignment]
                if all(self._eval(condition) for condition in first.ifs):
                    yield from self._bindings(inner, own, turns)

        def _eval_name(self, node: Any) -> Any:
            if node.id in CONSTANTS:
                return CONSTANTS[node.id]
            try:
                return self.names[node.id]  # type: ignore[index]
            except KeyError as fault:
                guess = did_you_mean(node.id, list(self.names))  # type: ignore[arg-type]
                raise ExpressionError(f"there is no name {node.id}{guess}") from fault

        def _eval_call(self, node: Any) -> Any:
            name = node.func.id
            if name == "csv":
                # It depends on the protocol: files are found beside it.
                self.functions["csv"] = self.names.get("csv", FUNCTIONS["csv"])  # type: ignore
            elif name in self.named:  # a run brings them along with the names
                self.functions[name] = self.names.get(f"{name}()", self.named[name])  # type: ignore
            return super()._eval_call(node)

        def _eval_attribute(self, node: Any) -> Any:
            if node.attr in TIMES and (step := step_of(node.value)) is not None:
                times_of = getattr(self.names.get("steps"), "times_of", None)  # type: ignore
                answer = self._eval(node.value)
                if times_of and not (isinstance(answer, Mapping) and node.attr in answer):
                    return times_of(step).get(node.attr)
            return field_of(self._eval(node.value), node.attr, lenient=in_answer(node.value))

        def _eval_subscript(self, node: Any) -> Any:
            index = self._eval(node.slice)
            return item_of(self._eval(node.value), index, lenient=in_answer(node.value))

    return Evaluator


def _items(value: Any) -> Sequence[Any]:
    if isinstance(value, str) or not isinstance(value, Sequence):
        raise ExpressionError(f"`for ... in {words(value)}`: it is not a list")
    return value


def _bound(target: ast.expr, item: Any) -> dict[str, Any]:
    """The names of a comprehension with an item's values."""
    if isinstance(target, ast.Name):
        return {target.id: item}
    names = [one.id for one in target.elts]  # type: ignore[attr-defined]
    if len(values := _items(item)) != len(names):
        raise ExpressionError(f"`for {', '.join(names)}`: an item has {len(values)} values")
    return dict(zip(names, values, strict=True))


def _finite(value: Any) -> Any:
    number = value.magnitude if is_quantity(value) else value
    if is_number(number) and not math.isfinite(number):  # OverflowError of a whole one
        raise ExpressionError("the result is not a finite number")
    return value


def _sentence(fault: Exception) -> str:
    """The message of a fault of an operator, a function or pint."""
    if isinstance(fault, TypeError):
        text = str(fault)
        if "argument" in text:
            name, _, rest = text.partition("()")
            return f"{PUBLIC.get(name, name)}:{rest}"
        return f"values that cannot be combined: {text}"
    if isinstance(fault, ZeroDivisionError):
        return "a division by zero"
    if isinstance(fault, OverflowError):
        return "a number that is too large"
    return str(fault) or type(fault).__name__
