"""Closed shapes from the models of a protocol: their keys, forms and choices, with descriptions.

The keys and forms come from the models themselves, so a key added there appears here at once.
What pydantic cannot know (what may be computed, which text is a time) is in `VALUES`.
"""

from functools import cache
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import model_json_schema

from ...schemas.protocol import (
    STEP_LISTS,
    Defaults,
    KeepGoing,
    Retry,
    Until,
    Watch,
    protocol_as_json_schema,
)
from ..language.shape import FORMS
from .values import Shape, condition, count, items, names, time
from .words import about, choices_for, words_for

STEPS: Shape = {"type": "array", "items": {"$ref": "#/$defs/step"}}
SOME_STEPS: Shape = {**STEPS, "minItems": 1}
NAME = r"^[A-Za-z][A-Za-z0-9_]*$"


def _retry() -> Shape:
    inner = closed(Retry)
    return {
        **inner,
        "type": ["integer", "object"],
        "minimum": 1,
        "errorMessage": "Expected a whole number from 1, or {attempts: 3, wait: 1 s}.",
    }


def _keep_going() -> Shape:
    return {
        **closed(KeepGoing),
        "type": ["boolean", "object"],
        "errorMessage": "Expected true, or {max_failed: 5, in_a_row: 3}.",
    }


def _wait() -> Shape:
    shape = time(minimum=0, examples=["1 s"])
    return {**shape, **closed(Until), "type": [*shape["type"], "object"]}


VALUES: dict[str, Any] = {
    "when": condition, "if": condition, "while": condition, "require": condition,
    "repeat": lambda: {**count(), "examples": [10]}, "max": lambda: {**count(), "examples": [10]},
    "max_failed": lambda: {**count(), "examples": [3]}, "in_a_row": lambda: {**count(), "examples": [3]},
    "timeout": lambda: time(exclusiveMinimum=0, examples=["30 s"]),
    "wait": _wait,
    "attempts": lambda: {"type": "integer", "minimum": 1, "maximum": 1000, "examples": [3]},
    "Retry.wait": lambda: time(computed=False, minimum=0, examples=["1 s"]),
    "max_wait": lambda: time(computed=False, minimum=0),
    "at_once": lambda: {**count(), "examples": [3]},
    "every": lambda: time(exclusiveMinimum=0, examples=["5 s"]),
    "stale": lambda: time(exclusiveMinimum=0, examples=["30 s"]),
    "watch": lambda: {"type": "array", "minItems": 1, "items": closed(Watch)},
    "Watch.then": lambda: {
        "if": {"type": "string"}, "then": {"enum": ["pause"]}, "else": {"$ref": "#/$defs/alternative"},
    },
    "retry": _retry,
    "on": lambda: {"type": "array", "minItems": 1, "items": {"$ref": "#/$defs/error-name"}},
    "keep_going": _keep_going,
    "defaults": lambda: closed(Defaults),
    "foreach": lambda: names(NAME, 60, items(), minProperties=1, maxProperties=1),
    "params": lambda: names(NAME, 60, {"$ref": "#/$defs/param"}),
    "Protocol.devices": lambda: {"$ref": "#/$defs/devices"},
    "on_resume": lambda: STEPS, "finally": lambda: STEPS,
    **{key: lambda: SOME_STEPS for key in STEP_LISTS},
    "fallback": lambda: {
        "type": "array", "minItems": 1, "items": {"$ref": "#/$defs/alternative"},
    },
}  # fmt: skip


def closed(model: type[BaseModel]) -> Shape:
    """A model as an object with its keys and no others."""
    raw = _raw(model)
    return {
        "type": "object",
        "description": about(model),
        "properties": {key: _key(model, key, said) for key, said in raw["properties"].items()},
        "required": list(raw.get("required", [])),
        "additionalProperties": False,
    }


@cache
def _raw(model: type[BaseModel]) -> dict[str, Any]:
    return _all_models().get(model.__name__) or model_json_schema(model, by_alias=True)


@cache
def _all_models() -> dict[str, dict[str, Any]]:
    """Made once: pydantic takes a tenth of a second for every model that contains steps."""
    made = protocol_as_json_schema()
    return {**made["$defs"], "Protocol": made}


def _key(model: type[BaseModel], key: str, said: dict[str, Any]) -> Shape:
    value = VALUES.get(f"{model.__name__}.{key}") or VALUES.get(key)
    shape = {**(value() if value else plain(said)), "description": words_for(model, key)}
    choices = choices_for(model, key)
    if choices:
        shape["enumDescriptions"] = [choices[choice] for choice in shape["enum"]]
    return shape


def plain(said: dict[str, Any]) -> Shape:
    """Pydantic's schema of a field, without its noise; an absent value is not written as null."""
    if "anyOf" in said:
        branches = [branch for branch in said["anyOf"] if branch != {"type": "null"}]
        if len(branches) == 1:
            return plain(branches[0])
        return {"type": list(dict.fromkeys(branch["type"] for branch in branches))}
    if "patternProperties" in said:
        ((pattern, each),) = said["patternProperties"].items()
        more = {key: said[key] for key in ("minProperties", "maxProperties") if key in said}
        return names(pattern, said["propertyNames"]["maxLength"], plain(each), **more)
    if "const" in said and said.get("type") == "string":
        return {"type": "string", "enum": [said["const"]]}
    kept = {key: value for key, value in said.items() if key not in ("title", "default")}
    if "items" in kept:
        kept["items"] = plain(kept["items"])
    if kept.get("pattern") in FORMS:
        kept["patternErrorMessage"] = f"Expected {FORMS[kept['pattern']]}."
    return kept
