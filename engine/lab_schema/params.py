"""The shape of a declared parameter: a quantity has a unit, and values match the type."""

from ...schemas.protocol import Param
from .models import closed
from .values import Shape, quantity

VALUES: dict[str, Shape] = {
    "quantity": quantity(None, "a number with a unit, such as 0.2 mm", computed=False),
    "number": {"type": "number"},
    "integer": {"type": "integer"},
    "string": {"type": "string"},
    "boolean": {"type": "boolean"},
    "array": {"type": "array"},
}


def param_shape() -> Shape:
    """One parameter of a protocol."""
    shape = closed(Param)
    shape["allOf"] = [_of_type(name) for name in shape["properties"]["type"]["enum"]]
    return shape


def _of_type(name: str) -> Shape:
    value = VALUES[name]
    keys = ("default",) if name == "array" else ("default", "minimum", "maximum")
    then: Shape = {"properties": dict.fromkeys(keys, value)}
    if name == "quantity":
        then["required"] = ["unit"]
        then["errorMessage"] = "A quantity needs its unit: add `unit: mm`."
    else:
        says = f"A {name} has no unit; did you mean `type: quantity`?"
        then["properties"]["unit"] = {"type": "null", "errorMessage": says, "doNotSuggest": True}
    return {"if": {"required": ["type"], "properties": {"type": {"const": name}}}, "then": then}
