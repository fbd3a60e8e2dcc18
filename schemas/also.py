"""Whether a contract keeps the promises of an earlier one, as its `also` says."""

from collections.abc import Iterator
from typing import Any

from .contract import Action, Contract, JsonSchema

LOWER, UPPER = ("minimum", "exclusiveMinimum"), ("maximum", "exclusiveMaximum")


def broken_promises(later: Contract, earlier: Contract) -> Iterator[str]:
    """Each way in which a device of the later contract would surprise a protocol for the earlier one."""
    for word in ("concurrent", "on_lease_lapse"):
        if getattr(later, word) != getattr(earlier, word):
            yield f"{word} is {getattr(later, word)}, not {getattr(earlier, word)}"
    if later.safe_state != earlier.safe_state:
        yield f"its safe state is {later.safe_state}, not {earlier.safe_state}"
    yield from _fewer("status", later.status, earlier.status)
    for name, action in earlier.actions.items():
        if name not in later.actions:
            yield f"it has no action {name}"
        else:
            yield from _of_action(name, later.actions[name], action)


def _of_action(name: str, later: Action, earlier: Action) -> Iterator[str]:
    for word in ("effect", "probe", "cancel", "meanwhile", "danger"):
        if getattr(later, word) != getattr(earlier, word):
            yield f"{name}: {word} is {getattr(later, word)}, not {getattr(earlier, word)}"
    for error, told in earlier.errors.items():
        if error not in later.errors:
            yield f"{name}: it has no error {error}"
        elif later.errors[error].happened != told.happened:
            yield f"{name}: {error} says happened: {later.errors[error].happened}, not {told.happened}"
    if more := sorted(set(later.required()) - set(earlier.required())):
        yield f"{name}: it needs {', '.join(more)}"
    schemas = later.param_schemas()
    for param, schema in earlier.param_schemas().items():
        if param not in schemas:
            yield f"{name}: it has no parameter {param}"
        else:
            yield from _narrower(f"{name}.{param}", schemas[param], schema)
    yield from _fewer(name, later.returns, earlier.returns)
    if lacking := sorted(
        set(earlier.returns.get("required", [])) - set(later.returns.get("required", []))
    ):
        yield f"{name}: {', '.join(lacking)} may be missing from what it returns"


def _narrower(name: str, later: JsonSchema, earlier: JsonSchema) -> Iterator[str]:
    """What the earlier one takes and the later one does not."""
    for word in ("type", "unit", "format", "default"):
        if later.get(word) != earlier.get(word):
            yield f"{name}: {word} is {later.get(word)}, not {earlier.get(word)}"
    if "enum" in later and not set(earlier.get("enum", [None])) <= set(later["enum"]):
        yield f"{name}: it takes {later['enum']} only"
    for words, sign in ((LOWER, 1), (UPPER, -1)):
        edge, former = _edge(later, words), _edge(earlier, words)
        if edge is not None and (former is None or sign * edge > sign * former):
            former_words = "" if former is None else f", not {former:g}"
            yield f"{name}: {words[0]} is {edge:g}{former_words}"


def _edge(schema: JsonSchema, words: tuple[str, str]) -> float | None:
    return next((float(schema[word]) for word in words if word in schema), None)


def _fewer(name: str, later: JsonSchema, earlier: JsonSchema) -> Iterator[str]:
    """Fields that the earlier one tells and the later one does not, or otherwise."""
    fields: dict[str, Any] = later.get("properties", {})
    for field, schema in earlier.get("properties", {}).items():
        if field not in fields:
            yield f"{name}: it does not tell {field}"
        elif (fields[field].get("type"), fields[field].get("unit")) != (
            schema.get("type"),
            schema.get("unit"),
        ):
            yield f"{name}: {field} is of another type or unit"
