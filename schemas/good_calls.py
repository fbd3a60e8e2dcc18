"""Valid calls of a contract's actions, how long they take, and how fast a clock may run for tests."""

from typing import Any

from .contract import Action, Contract
from .quantity import seconds

Schema = dict[str, Any]
CALM_S = 2.5
"""An action that the contract tests must interrupt takes at least this long."""


def plain(name: str, schema: Schema) -> Any:
    """A value that a schema allows: the default, the first of the list, the middle of a range."""
    for word in ("const", "default"):
        if word in schema:
            return schema[word]
    if "enum" in schema:
        return schema["enum"][0]
    kind = schema.get("type", "object")
    kind = kind[0] if isinstance(kind, list) else kind
    if kind in ("number", "integer"):
        return _middle(schema, whole=kind == "integer")
    match kind:
        case "string":
            least = "x" * schema.get("minLength", 0)
            return f"{name}.dat" if schema.get("format") == "path" else least
        case "boolean":
            return False
        case "array":
            return [plain(name, schema.get("items", {}))] * schema.get("minItems", 0)
        case "null":
            return None
    needed = schema.get("required", [])
    return {n: plain(n, s) for n, s in schema.get("properties", {}).items() if n in needed}


def _middle(schema: Schema, *, whole: bool) -> float:
    low = schema.get("minimum", schema.get("exclusiveMinimum"))
    high = schema.get("maximum", schema.get("exclusiveMaximum"))
    if low is None:
        low = 0 if high is None else high - 2
        high = 0 if high is None else high
    high = low + 2 if high is None else high
    return (low + high) // 2 if whole else (low + high) / 2


def good_call(action: Action) -> dict[str, Any]:
    """Parameters that the contract allows: those required, and as many more as it demands."""
    schemas = action.param_schemas()
    names = action.required() or list(schemas)[: action.params.get("minProperties", 0)]
    for one_of in ("oneOf", "anyOf"):  # where one of several parameters is needed, take the first
        first = next(iter(action.params.get(one_of, [])), {})
        names = [*names, *(name for name in first.get("required", []) if name not in names)]
    return {name: plain(name, schemas[name]) for name in names}


def duration_s(action: Action) -> float:
    """The duration from the contract; 1 s if it gives none."""
    return 1.0 if action.duration is None else seconds(action.duration)


def lasting(contract: Contract) -> str:
    """The action that the contract tests interrupt: the shortest cancellable one, or the shortest."""
    cancellable = [n for n, a in contract.actions.items() if a.cancel]
    return min(cancellable or contract.actions, key=lambda n: duration_s(contract.actions[n]))


def slow_clock(contract: Contract) -> float:
    """How fast a clock may run while an interrupted action still takes more than two seconds."""
    caught = [a for n, a in contract.actions.items() if a.cancel or n == lasting(contract)]
    caught += [a for a in contract.actions.values() if a.effect == "once"]
    return round(min(duration_s(a) for a in caught) / CALM_S, 4)
