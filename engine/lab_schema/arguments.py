"""The shape of one action's `with`, from its contract and the limits of the lab's bench."""

from collections.abc import Mapping
from typing import Any

from ...schemas.contract import Action
from ...schemas.lab import Limit
from ...schemas.quantity import kind_of_unit, magnitude_in, number_text
from ..language.wanted import bounds_text, wants
from .values import COMPUTED, Shape, quantity

BOUNDS = ("minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum")
WHOLE = ("required", "minProperties", "maxProperties", "dependentRequired")
KNOWN = {
    *BOUNDS, "type", "unit", "description", "summary", "title", "default", "examples", "enum",
    "const", "pattern", "format", "minLength", "maxLength", "multipleOf", "items", "minItems",
    "maxItems", "uniqueItems", "properties", "required", "additionalProperties", "minProperties",
    "maxProperties", "dependentRequired", "contentMediaType",
}  # fmt: skip
"""A parameter with any other keyword (`$ref`, `oneOf`, ...) is left to `labrun check`."""


def with_shape(label: str, action: Action, limits: Mapping[str, Limit]) -> Shape:
    """All parameters of an action, optional and required."""
    params = action.param_schemas()
    shape: Shape = {
        "type": "object",
        "title": label,
        "description": action.summary or "The parameters of the action.",
        "properties": {name: argument(said, limits.get(name)) for name, said in params.items()},
        "additionalProperties": action.params.get("additionalProperties", False) is not False,
    }
    return {**shape, **{key: action.params[key] for key in WHOLE if key in action.params}}


def is_needed(action: Action) -> bool:
    """True if the action requires a `with`."""
    return bool(action.required()) or action.params.get("minProperties", 0) > 0


def argument(said: Any, limit: Limit | None = None) -> Shape:
    """One parameter: its contract's schema, narrowed by the bench; or an expression."""
    if not isinstance(said, Mapping):
        return {}
    described = {"description": _describe(said, limit)}
    if not set(said) <= KNOWN:
        return described
    kinds = [said["type"]] if isinstance(said.get("type"), str) else list(said.get("type", []))
    if "unit" in said and set(kinds) <= {"number", "integer"} and "enum" not in said:
        return {**described, **_with_unit(said, limit, kinds)}
    if not kinds or "enum" in said or "const" in said or "string" in kinds:
        return {**described, **_text_or_choice(said)}
    return {**described, **_other(said, limit, kinds)}


def _with_unit(said: Mapping[str, Any], limit: Limit | None, kinds: list[str]) -> Shape:
    unit = said["unit"]
    example = f"{_example(said, limit)} {unit}"
    says = f"{kind_of_unit(unit)} such as {example}"
    shape = quantity(unit, says, **_bounds(said, limit), examples=[example])
    return {**shape, "type": [*(kinds or ["number"]), "string"]}


def _bounds(said: Mapping[str, Any], limit: Limit | None) -> Shape:
    found = {key: said[key] for key in BOUNDS if key in said}
    for key, narrower in (("minimum", max), ("maximum", min)):
        given = getattr(limit, key, None)
        if given is not None and (said.get("unit") or not isinstance(given, str)):
            bare = magnitude_in(given, said["unit"]) if said.get("unit") else given
            found[key] = narrower(found.get(key, bare), bare)
    return found


def _example(said: Mapping[str, Any], limit: Limit | None) -> str:
    bounds = _bounds(said, limit)
    low = bounds.get("minimum", bounds.get("exclusiveMinimum", 0))
    high = bounds.get("maximum", low + 10)
    return number_text(min(max(10, low), high))


def _text_or_choice(said: Mapping[str, Any]) -> Shape:
    """Unchanged, since an expression is text; with choices or forms, either is accepted."""
    kept = {key: value for key, value in said.items() if key not in ("unit", "description")}
    if set(kept) <= {"type", "format", "summary", "title", "default", "examples"}:
        return kept
    if "enum" in kept:
        return {"anyOf": [kept, {"type": "string", "pattern": COMPUTED}]}
    return {"if": {"type": "string", "pattern": COMPUTED}, "else": kept}


def _other(said: Mapping[str, Any], limit: Limit | None, kinds: list[str]) -> Shape:
    kept = {
        key: value for key, value in said.items() if key not in ("unit", "description", "summary")
    }
    if "items" in kept:
        kept["items"] = argument(kept["items"])
    if "properties" in kept:
        kept["properties"] = {name: argument(inner) for name, inner in kept["properties"].items()}
    if isinstance(kept.get("additionalProperties"), Mapping):
        kept["additionalProperties"] = argument(kept["additionalProperties"])
    says = f"Expected {wants(said)} or ${{{{ ... }}}}."
    return {
        **kept, **_bounds(said, limit),
        "type": [*kinds, "string"], "pattern": COMPUTED, "patternErrorMessage": says,
    }  # fmt: skip


def _describe(said: Mapping[str, Any], limit: Limit | None) -> str:
    """`Which place along x. A length (mm), 0..730 mm.`"""
    words = said.get("description") or said.get("summary") or ""
    form = wants(said) if set(said) <= KNOWN else ""
    if _bounds(said, limit):
        form += f", {bounds_text(said, limit)}"
    if said.get("format") == "path":
        form += ", the name of a file in the run's folder"
    if "default" in said:
        form += f"; {said['default']} if omitted"
    parts = [part.rstrip(".") for part in (words, form) if part]
    return f"{'. '.join(part[0].upper() + part[1:] for part in parts)}." if parts else ""
