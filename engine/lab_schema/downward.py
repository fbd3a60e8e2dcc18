"""Shapes that go down from the top of a protocol into all of its steps."""

from ...schemas.protocol import STEP_LISTS
from .values import Shape

SECTIONS = ("steps", "on_resume", "finally")


def everywhere(name: str) -> Shape:
    """The shape of this name in every section that holds steps."""
    return {"properties": {section: {"$ref": f"#/$defs/{name}-list"} for section in SECTIONS}}


def down(name: str, do: Shape, *rules: Shape) -> dict[str, Shape]:
    """Shapes that go down into all steps; `do` is what they say of the action there.

    A list and a step are two shapes, since editors follow `items` without looking where it ends;
    and an empty step is left alone, or the editor would take it for a whole one and complete nothing.
    """
    inner, listed = {"$ref": f"#/$defs/{name}"}, {"$ref": f"#/$defs/{name}-list"}
    alternative = {"if": {"type": "array"}, "then": listed, "else": inner}
    properties = {
        **dict.fromkeys(STEP_LISTS, listed),
        "fallback": {"doNotSuggest": True, "items": alternative},
        "do": {"doNotSuggest": True, **do},
    }
    said = {"properties": properties, **({"allOf": list(rules)} if rules else {})}
    return {
        name: {"if": {"type": "object"}, "then": said},
        f"{name}-list": {"doNotSuggest": True, "items": inner},
    }


def given(test: Shape, title: str, shape: str, *, needed: bool) -> Shape:
    """Where `do` is this action, `with` is so."""
    then: Shape = {"title": title, "properties": {"with": {"$ref": f"#/$defs/{shape}"}}}
    if needed:
        then["required"] = ["with"]
    return {
        "if": {"type": "object", "required": ["do"], "properties": {"do": test}},
        "then": then,
    }
