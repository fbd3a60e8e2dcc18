"""Shapes that apply from the top of a protocol down to all of its steps."""

from ...schemas.protocol import STEP_LISTS
from .values import Shape

SECTIONS = ("steps", "on_resume", "finally")


def everywhere(name: str) -> Shape:
    """The shape of this name in every section that holds steps."""
    return {"properties": {section: {"$ref": f"#/$defs/{name}-list"} for section in SECTIONS}}


def down(name: str, do: Shape, *rules: Shape) -> dict[str, Shape]:
    """Shapes that apply down to all steps; `do` is the shape of the action there.

    A list and a step are two shapes, since editors follow `items` without checking where it ends;
    an empty step is skipped, or the editor would take it for a complete one and suggest nothing.
    """
    inner, listed = {"$ref": f"#/$defs/{name}"}, {"$ref": f"#/$defs/{name}-list"}
    alternative = {"if": {"type": "array"}, "then": listed, "else": inner}
    properties = {
        **dict.fromkeys(STEP_LISTS, listed),
        "fallback": {"doNotSuggest": True, "items": alternative},
        "watch": {
            "doNotSuggest": True,
            "items": {"allOf": [inner, {"properties": {"then": alternative}}]},
        },
        "do": {"doNotSuggest": True, **do},
    }
    said = {"properties": properties, **({"allOf": list(rules)} if rules else {})}
    return {
        name: {"if": {"type": "object"}, "then": said},
        f"{name}-list": {"doNotSuggest": True, "items": inner},
    }


def given(test: Shape, title: str, shape: str, *, needed: bool) -> Shape:
    """The shape of `with` where `do` is this action."""
    then: Shape = {"title": title, "properties": {"with": {"$ref": f"#/$defs/{shape}"}}}
    if needed:
        then["required"] = ["with"]
    return {
        "if": {"type": "object", "required": ["do"], "properties": {"do": test}},
        "then": then,
    }
