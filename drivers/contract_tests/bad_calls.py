"""Calls that a contract forbids, made from a valid one and the schema of the action's parameters."""

from collections.abc import Iterator
from typing import Any

from ...schemas.contract import Action
from ..server.arguments import Limits, narrowed

Params = dict[str, Any]
NOT_OF_TYPE: dict[str, Any] = {
    "number": "far", "integer": 1.5, "string": 7, "boolean": "yes", "array": "all", "object": [],
}  # fmt: skip


def bad_calls(action: Action, good: Params, limits: Limits) -> Iterator[tuple[str, Params]]:
    """What is wrong -> parameters that have only this fault."""
    schema = narrowed(action.params, limits)
    if not schema["properties"] or schema.get("additionalProperties") is False:
        yield "an unknown parameter", {**good, "no_such_parameter": 1}
    for name in schema.get("required", []):
        yield f"{name} missing", {key: value for key, value in good.items() if key != name}
    if schema.get("minProperties"):
        yield "nothing at all", {}
    for name, one in schema["properties"].items():
        for what, value in _bad_values(one):
            yield f"{name} {what}", {**good, name: value}


def _bad_values(schema: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    kind = schema.get("type")
    if isinstance(kind, str):
        yield "of another type", NOT_OF_TYPE.get(kind)
    if kind in ("number", "integer"):
        yield "NaN", float("nan")
        yield "infinite", float("inf")
    for word, beyond in (("minimum", -1), ("maximum", 1)):
        if word in schema:
            yield f"beyond its {word}", schema[word] + beyond
    for word in ("exclusiveMinimum", "exclusiveMaximum"):
        if word in schema:
            yield f"at its {word}", schema[word]
    if "enum" in schema:
        yield "not on the list", "no such word"
    if schema.get("format") == "path":
        yield "outside the run's folder", "../outside.txt"
        yield "an absolute path", "/etc/outside.txt"
