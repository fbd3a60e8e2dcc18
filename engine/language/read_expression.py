"""Parse an expression: Python's syntax without side effects, plus quantities."""

import ast
import keyword
import math
import re
import warnings
from collections.abc import Iterator
from typing import Any

from ...schemas.quantity import UnitError, unit_of
from .functions import FUNCTIONS, LITERAL
from .operators import OPERATORS
from .suggest import did_you_mean

WRITTEN = re.compile(rf"{LITERAL}\(([^,()]*), '([^']*)'\)")
LONGEST = 2000
GOES_ON = re.compile(r"(?:[-+*/%<>=,.]|\b(?:if|else|and|or|not|in|for))\s*$")
"""How an expression ends that something is still missing of."""
DEEPEST = 40
COUNTED = re.compile(r"([A-Za-z_]\w*) *([-+*/])= *([^=]+)")
COLONS = re.compile(r"\s*([^:'\"\[{]+?)\s*:\s*([^:]+?)\s*:\s*([^:'\"\]}]+?)\s*")
"""A range as MATLAB has it."""
CONSTANTS = {"True": True, "False": False, "None": None, "true": True, "false": False, "null": None}
INSTEAD = {
    "always": "what always runs at the end stands under `finally`",
    "failure": "what runs where a step fails is its `fallback`",
    "success": "a step runs only where those before it have succeeded",
    "str": "format(x) makes text of a value",
    "float": "a quantity without its unit is x / 1 mm",
    "print": "`log:` is a step that prints",
    "random": "a function of your own gives random numbers",
}
"""What is written in place of a function that other languages have."""
GROWS = {"append": "a list grows by a + [x]", "extend": "a list grows by a + b"}
METHODS = (
    *GROWS, "upper", "lower", "strip", "split", "join", "replace", "startswith", "endswith", "keys",
    "items", "values",
)  # fmt: skip
"""Of Python's text, lists and tables; no action has such a name."""
KEYWORDS = {"and", "or", "not", "in", "is", "if", "else", "for", "lambda"}
TOKEN = re.compile(
    r"""(?P<text>'(?:[^'\\]|\\.)*'|"(?:[^"\\]|\\.)*")"""
    r"""|(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"""
    r"""(?:[ ]*(?P<unit>[^\W\d_]\w*|[µ°Ω]\w*|%(?!\s*[\w(.'"]))"""
    r"""(?P<per>/[^\W\d_]\w*(?![\w.(\[]))?)?"""
    r"""|(?P<name>[^\W\d]\w*)"""
)
"""Texts and names are skipped, so that no number in them is taken for a quantity."""
ALLOWED = (
    ast.Expression, ast.Constant, ast.Name, ast.Attribute, ast.Subscript, ast.Slice, ast.List,
    ast.Tuple, ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare, ast.IfExp, ast.Call, ast.keyword,
    ast.Load, ast.Store, ast.And, ast.Or, ast.ListComp, ast.GeneratorExp, ast.comprehension, *OPERATORS,
)  # fmt: skip


class ExpressionError(ValueError):
    """An expression that cannot be read, or cannot be evaluated now; the message says why.

    `reason` is the message without the expression, for places that show the expression anyway.
    """

    def __init__(self, reason: str, expression: str = "") -> None:
        super().__init__(f"{reason} (in {short(expression)})" if expression else reason)
        self.reason = reason


def short(text: str) -> str:
    """An expression as messages quote it."""
    return text if len(text) <= 80 else text[:77] + "..."


def parse(text: str, own: frozenset[str] = frozenset()) -> ast.Expression:
    """The syntax tree of an expression; raises ExpressionError if it is invalid or not allowed.

    `own`: the functions that the protocol has besides those of the language.
    """
    if not text:
        raise ExpressionError("empty expression: `${{ }}`")
    if len(text) > LONGEST:
        raise ExpressionError(
            f"an expression of {len(text):,} characters; the limit is {LONGEST:,}"
        )
    prepared = _with_quantities(" ".join(text.splitlines()))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(prepared, mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError) as fault:
        raise ExpressionError(_unreadable(text, fault)) from fault
    _refuse(tree, own)
    return _Signed().visit(tree)


class _Signed(ast.NodeTransformer):
    """`-20 degC` is one value: the minus belongs to the number, also where zero is arbitrary."""

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.AST:
        self.generic_visit(node)
        of = node.operand
        if isinstance(node.op, ast.USub) and isinstance(of, ast.Call) and _is_literal(of):
            number = of.args[0]
            assert isinstance(number, ast.Constant) and isinstance(number.value, int | float)
            of.args[0] = ast.copy_location(ast.Constant(-number.value), number)
            return of
        return node


def _is_literal(node: ast.Call) -> bool:
    return isinstance(node.func, ast.Name) and node.func.id == LITERAL


def _with_quantities(text: str) -> str:
    """The text with `0.1 mm` written as a call, since Python has no units."""

    def replace(match: re.Match[str]) -> str:
        unit = match["unit"]
        if match["number"] is None or unit is None:
            return match[0]
        if unit in KEYWORDS:
            # `1 if x`: a keyword after a number is not a unit, even `in` (inch).
            return f"{match['number']} {match[0][len(match['number']) :].lstrip()}"
        per = match["per"] or ""
        try:
            unit_of(unit + per)
        except UnitError as fault:
            guess = str(fault).partition("; ")[2]
            raise ExpressionError(
                f"{match[0]}: {unit}{per} is not a unit{'; ' * bool(guess)}{guess}"
            ) from fault
        return f"{LITERAL}({match['number']},{unit + per!r})"

    return TOKEN.sub(replace, text)


def _unreadable(whole: str, fault: BaseException) -> str:
    text = short(whole)
    if found := re.search(r"<>|~=|=[<>]", text):
        return f"{text}: write `{'!=' if found[0] in ('<>', '~=') else found[0][::-1]}`"
    if counted := COUNTED.fullmatch(text):
        return f"{text}: write {counted[1]} {counted[2]} {counted[3]}; the key of a `set` names it"
    if bounds := COLONS.fullmatch(text):
        return f"{text}: write span({bounds[1]}, {bounds[3]}, {bounds[2]})"
    if re.search(r"(?<![=!<>])=(?!=)", text) and "(" not in text:
        return f"{text}: `=` assigns a value; `==` compares"
    if "&&" in text or "||" in text or re.search(r"!(?!=)", text):
        return f"{text}: write `and`, `or`, `not`"
    if " ? " in text:
        return f"{text}: write `a if condition else b`"
    if word := re.search(r"\b(AND|OR|NOT|And|Or|Not)\b", text):
        return f"{text}: write `{word[1].lower()}`, in small letters"
    if "${{" in text:
        before = text.partition("${{")[0]
        if before.count("}") > before.count("{"):
            return f"{text}: a }} is missing; write `}}}}` before the next `${{{{`"
        return f"{text}: an expression within an expression; remove the inner ${{{{ }}}}"
    reserved = [word for word in re.findall(r"\.\s*(\w+)", text) if keyword.iskeyword(word)]
    if reserved:
        return f"{text}: {reserved[0]} is a word of expressions themselves; choose another name"
    reason = _reason(fault) if isinstance(fault, SyntaxError) else "it is nested too deeply"
    return f"{text}: this cannot be read as an expression ({reason})"


def _reason(fault: SyntaxError) -> str:
    """Python's own words, and the sign at which it gave up where these do not name it."""
    if fault.msg != "invalid syntax" or fault.text is None or fault.offset is None:
        return fault.msg
    if GOES_ON.search(fault.text):
        return "it ends too early"
    found = re.match(r"\s*(\w+|\S)", fault.text[fault.offset - 1 :])
    return f"{fault.msg} at `{found[1]}`" if found and found[1] != LITERAL else fault.msg


def _refuse(tree: ast.Expression, own: frozenset[str]) -> None:
    """Raise for anything but arithmetic, comparisons, fields, items and known functions."""
    _refuse_node(tree, own)
    level: list[ast.AST] = [tree]
    for _ in range(DEEPEST):
        level = [child for node in level for child in ast.iter_child_nodes(node)]
        for node in level:
            _refuse_node(node, own)
        if not level:
            return
    raise ExpressionError("the expression is nested too deeply; compute part of it with `set`")


def as_written(node: ast.AST) -> str:
    """A part of an expression, as close as possible to how it was written."""
    text = WRITTEN.sub(r"\1 \2", ast.unparse(node))
    return text if len(text) <= 60 else text[:57] + "..."


def _refuse_node(node: ast.AST, own: frozenset[str]) -> None:
    if not isinstance(node, ALLOWED):
        more = "; `**` is a power" if isinstance(node, ast.BitXor) else ""
        if isinstance(node, ast.expr):
            more = f": {as_written(node)}"
        if isinstance(node, ast.JoinedStr):
            more += "; a text has values within it by ${{ }}"
        raise ExpressionError(f"{_construct(node)} is not allowed in an expression{more}")
    if isinstance(node, ast.Constant) and not _usable(node.value):
        if isinstance(node.value, float):
            raise ExpressionError("a number that is too large")
        raise ExpressionError(f"{node.value!r} is not allowed in an expression")
    if isinstance(node, ast.Attribute) and node.attr.startswith("_"):
        raise ExpressionError(f"a field name must not begin with _: {node.attr}")
    if isinstance(node, ast.comprehension):
        _refuse_comprehension(node)
    if isinstance(node, ast.Call):
        _refuse_call(node, own)
    if isinstance(node, ast.Expression) and isinstance(node.body, ast.Tuple):
        raise ExpressionError("a comma: a number has a decimal point, and a list brackets")


def _refuse_comprehension(node: ast.comprehension) -> None:
    if node.is_async:
        raise ExpressionError("`async` is not allowed in an expression")
    targets = node.target.elts if isinstance(node.target, ast.Tuple | ast.List) else [node.target]
    for target in targets:
        if not isinstance(target, ast.Name):
            raise ExpressionError(f"`for {ast.unparse(node.target)}` needs plain names")
        if target.id in CONSTANTS or target.id in ("params", "steps", "run", "error"):
            raise ExpressionError(f"`for {target.id}`: {target.id} already means something else")


def _usable(value: Any) -> bool:
    if isinstance(value, float):
        return math.isfinite(value)
    return isinstance(value, str | int | None)


def _refuse_call(node: ast.Call, own: frozenset[str]) -> None:
    if not isinstance(node.func, ast.Name):
        raise ExpressionError(_no_function(node.func))
    name = node.func.id
    if name not in FUNCTIONS and name not in own and name != LITERAL:
        known = did_you_mean(name, [*FUNCTIONS, *own]) or "; there are " + ", ".join(FUNCTIONS)
        numbers = [a.value for a in node.args if isinstance(a, ast.Constant)]
        if name in INSTEAD:
            known = f"; {INSTEAD[name]}"
        elif len(numbers) == len(node.args) == 1 and isinstance(numbers[0], int):
            known += f"; an item of a list is {name}[{numbers[0]}], and the first is {name}[0]"
        raise ExpressionError(f"there is no function {name}{known}")
    if any(isinstance(argument, ast.Starred) for argument in node.args):
        raise ExpressionError("`*` before an argument is not allowed in an expression")
    if any(keyword.arg is None for keyword in node.keywords):
        raise ExpressionError("`**` before an argument is not allowed in an expression")


def _no_function(called: ast.expr) -> str:
    """Why what is called is none of the functions: a method, an action, a module's function."""
    whole = ast.unparse(called)
    if isinstance(called, ast.Attribute) and called.attr in FUNCTIONS:
        return f"write {called.attr}(...), without {ast.unparse(called.value)}"
    if isinstance(called, ast.Attribute) and (way := _no_method(called)):
        return way
    if isinstance(called, ast.Attribute) and isinstance(called.value, ast.Name):
        return (
            f"{whole}(...) is no function; an action is a step, `{{id: a, do: {whole}}}`, "
            "whose result is steps.a"
        )
    return "only functions can be called: " + ", ".join(FUNCTIONS)


def _no_method(called: ast.Attribute) -> str:
    """The way on for a method; nothing for another name."""
    if called.attr not in METHODS:
        return ""
    way = GROWS.get(called.attr, "`functions` has those of your own")
    return f"{ast.unparse(called)}(...): values have no methods; {way}"


def _construct(node: ast.AST) -> str:
    known = {
        "Lambda": "lambda", "DictComp": "{... for ...}", "SetComp": "{... for ...}",
        "JoinedStr": "an f-string", "NamedExpr": "`:=`", "Dict": "{...}", "Set": "{...}",
        "Starred": "`*`", "Await": "await", "LShift": "`<<`", "RShift": "`>>`", "BitOr": "`|`",
        "BitXor": "`^`", "BitAnd": "`&`", "Invert": "`~`", "MatMult": "`@`",
    }  # fmt: skip
    return known.get(type(node).__name__, type(node).__name__)


def names_in(tree: ast.AST, own: frozenset[str] = frozenset()) -> Iterator[str]:
    """The names that an expression uses, without functions and without `own`."""
    if isinstance(tree, ast.Name):
        if tree.id not in CONSTANTS and tree.id not in own:
            yield tree.id
        return
    if isinstance(tree, ast.ListComp | ast.GeneratorExp):
        for part in tree.generators:
            yield from names_in(part.iter, own)
            own |= {node.id for node in ast.walk(part.target) if isinstance(node, ast.Name)}
            for condition in part.ifs:
                yield from names_in(condition, own)
        yield from names_in(tree.elt, own)
        return
    inside = (
        [*tree.args, *tree.keywords] if isinstance(tree, ast.Call) else ast.iter_child_nodes(tree)
    )
    for node in inside:
        yield from names_in(node, own)
