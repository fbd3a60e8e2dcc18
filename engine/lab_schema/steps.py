"""The shape of a step: the kind given by its keyword, closed.

One `if` per kind instead of a list of alternatives: a fault then points into the kind that was
meant, and an editor completes the keys of that kind only. A step with the keywords of two kinds
is checked as the first, in the order of the models.
"""

from ...schemas.contract import RESERVED_ERRORS
from ...schemas.protocol import STEP_KINDS, StepBase
from ..checks.fallbacks import CHOICES
from ..language.shape import keys_of
from .models import SOME_STEPS, closed
from .snippets import SNIPPETS
from .values import Shape

KEYWORDS = [kind.KIND for kind in STEP_KINDS]


def step_shapes(errors: dict[str, str]) -> dict[str, Shape]:
    """Name -> shape of every part of a step; `errors` are names for `retry: {on}`."""
    shapes: dict[str, Shape] = {
        "step": _step(),
        "step-without-keyword": _without_keyword(),
        "alternative": _alternative(),
        "error-name": _error_name(errors),
    }
    shapes |= {f"key-{key}": shape for key, shape in closed(StepBase)["properties"].items()}
    shapes |= {f"step-{kind.KIND}": _kind(kind) for kind in STEP_KINDS}
    return shapes


def _kind(kind: type[StepBase]) -> Shape:
    """One kind of step; keys of any step are defined once for all kinds."""
    shape = closed(kind)
    return {"title": kind.KIND, **shape, "properties": {**shape["properties"], **_anywhere()}}


def _anywhere() -> dict[str, Shape]:
    return {key: {"$ref": f"#/$defs/key-{key}"} for key in keys_of(StepBase)}


def _step() -> Shape:
    chosen: list[Shape] = []
    for index, keyword in enumerate(KEYWORDS):
        first = {"required": [keyword], "properties": dict.fromkeys(KEYWORDS[:index], False)}
        chosen.append(
            {"if": {"type": "object", **first}, "then": {"$ref": f"#/$defs/step-{keyword}"}}
        )
    none = {"properties": dict.fromkeys(KEYWORDS, False)}
    chosen.append(
        {"if": {"type": "object", **none}, "then": {"$ref": "#/$defs/step-without-keyword"}}
    )
    return {
        "type": "object",
        "errorMessage": "A step is keys with values, such as `do: role.action`.",
        "allOf": chosen,
    }


def _without_keyword() -> Shape:
    """What is suggested where a step begins, and the message for a missing keyword."""
    says = f"A step has one keyword that says what it does: {', '.join(KEYWORDS)}."
    shown = {kind.KIND: closed(kind)["properties"][kind.KIND] for kind in STEP_KINDS}
    return {
        "type": "object",
        "title": "step",
        "description": says,
        "properties": {**shown, **_anywhere()},
        "additionalProperties": False,
        "anyOf": [{"required": [keyword], "errorMessage": says} for keyword in KEYWORDS],
        "defaultSnippets": SNIPPETS,
    }


def _alternative() -> Shape:
    """One alternative of a `fallback`; an `ask` there has three choices."""
    choices = {
        "type": "array",
        "minItems": 1,
        "items": {
            "enum": list(CHOICES),
            "enumDescriptions": [
                "run the step again", "skip this iteration", "the step has failed",
            ],
        },
    }  # fmt: skip
    asked = {"if": {"required": ["ask"]}, "then": {"properties": {"choices": choices}}}
    return {
        "if": {"type": "array"},
        "then": SOME_STEPS,
        "else": {"allOf": [{"$ref": "#/$defs/step"}, asked]},
    }


def _error_name(errors: dict[str, str]) -> Shape:
    """Known names are suggested; `labrun check` checks whether this action declares them."""
    known = {**dict.fromkeys(RESERVED_ERRORS, "any action may end with this error"), **errors}
    return {
        "type": "string",
        "anyOf": [
            {"enum": list(known), "enumDescriptions": list(known.values())},
            {"pattern": "^[A-Za-z_][A-Za-z0-9_]*$"},
        ],
    }
