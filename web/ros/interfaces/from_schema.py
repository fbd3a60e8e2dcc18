"""JSON Schemas of a contract as ROS messages.

| schema | field |
| --- | --- |
| boolean, integer, number, string | `bool`, `int64`, `float64`, `string` |
| `maxLength`, `maxItems`, `minItems` = `maxItems` | `string<=N`, `T[<=N]`, `T[N]` |
| `enum`, `const` | constants beside the field |
| object with `properties` | a separate message |
| anything else | `string NAME_json`: the value as JSON text |
| null, or optional in what is sent to a device | `T[<=1]`: empty is null, or left out |
"""

from typing import Any

from ....schemas.contract import JsonSchema
from .kinds import Field, Message
from .names import constant_name, field_name, type_name

PRIMITIVES = {"boolean": "bool", "integer": "int64", "number": "float64", "string": "string"}
RANGES = {"minimum": ">=", "exclusiveMinimum": ">", "maximum": "<=", "exclusiveMaximum": "<"}
KINDS = {bool: "boolean", int: "integer", float: "number", str: "string"}


def message_of(
    schema: JsonSchema, package: str, name: str, *, sent: bool = False, summary: str = ""
) -> Message:
    """The message for an object's properties.

    `sent` to a device: optional fields may be left out. In a message from a device, an absent value
    is NaN, an empty string, 0 or false.
    """
    required = schema.get("required", [])
    fields: list[Field] = []
    for key, inner in schema.get("properties", {}).items():
        taken = [field.name for field in fields]
        fields.append(_field(key, inner, package, name, taken, sent, key not in required))
    return Message(package, name, tuple(fields), summary)


def _field(
    key: str, schema: Any, package: str, owner: str, taken: list[str], sent: bool, absent: bool
) -> Field:
    schema = schema if isinstance(schema, dict) else {}
    plain, nullable = _without_null(schema)
    default = plain.get("default")
    left_out = sent and absent and default is None
    kind = _kind(plain)
    comment = _comment(plain, left_out, nullable)
    if kind == "array":
        return _array(key, plain, package, owner, taken, sent, comment)
    one: dict[str, Any] = {"key": key, "comment": comment, "optional": nullable or left_out}
    one["array"] = "[<=1]" if one["optional"] else ""
    if kind == "object":
        inner = message_of(plain, package, type_name(owner, key), sent=sent)
        return Field(field_name(key, taken), inner.name, message=inner, **one)
    if kind not in PRIMITIVES:
        comment = f"{comment}; as JSON text" if comment else "as JSON text"
        one |= {"comment": comment, "optional": False, "array": ""}
        return Field(field_name(f"{key}_json", taken), "string", json=True, **one)
    name = field_name(key, taken)
    constants = _constants(name, plain)
    bound = plain.get("maxLength") if kind == "string" else None
    return Field(
        name, PRIMITIVES[kind], bound=bound, constants=constants,
        default=default if isinstance(default, (bool, int, float, str)) and not one["optional"] else None,
        **one,
    )  # fmt: skip


def _array(
    key: str, schema: Any, package: str, owner: str, taken: list[str], sent: bool, comment: str
) -> Field:
    items, nullable = _without_null(schema.get("items", {}))
    kind = _kind(items)
    if nullable or kind not in (*PRIMITIVES, "object"):
        words = f"{comment}; as JSON text" if comment else "as JSON text"
        name = field_name(f"{key}_json", taken)
        return Field(name, "string", key=key, json=True, comment=words)
    most, least = schema.get("maxItems"), schema.get("minItems")
    size = "" if most is None else f"{most}" if most == least else f"<={most}"
    name, within = field_name(key, taken), _comment(items, False, False)
    comment = "; ".join(words for words in (comment, within and f"each {within}") if words)
    one: dict[str, Any] = {"key": key, "array": f"[{size}]", "comment": comment}
    if kind == "object":
        inner = message_of(items, package, type_name(owner, key), sent=sent)
        return Field(name, inner.name, message=inner, **one)
    bound = items.get("maxLength") if kind == "string" else None
    return Field(name, PRIMITIVES[kind], bound=bound, constants=_constants(name, items), **one)


def _without_null(schema: Any) -> tuple[dict[str, Any], bool]:
    """A schema without its null, and whether it had one."""
    schema = schema if isinstance(schema, dict) else {}
    kinds = schema.get("type")
    if isinstance(kinds, list) and "null" in kinds:
        rest = [kind for kind in kinds if kind != "null"]
        return {**schema, "type": rest[0] if len(rest) == 1 else rest}, True
    words = schema.get("enum")
    if isinstance(words, list) and None in words:
        return {**schema, "enum": [word for word in words if word is not None]}, True
    return schema, False


def _kind(schema: dict[str, Any]) -> str:
    """The one type of a schema: object, array, a primitive, or `any`."""
    kind = schema.get("type")
    if kind is None and ("enum" in schema or "const" in schema):
        found = {KINDS.get(type(word), "any") for word in _enumerated(schema)}
        return found.pop() if len(found) == 1 else "any"
    if kind == "object":
        return "object" if schema.get("properties") else "any"
    return kind if isinstance(kind, str) else "any"


def _enumerated(schema: dict[str, Any]) -> list[Any]:
    return schema["enum"] if "enum" in schema else [schema["const"]] if "const" in schema else []


def _constants(field: str, schema: dict[str, Any]) -> tuple[tuple[str, Any], ...]:
    found: dict[str, Any] = {}
    for word in _enumerated(schema):
        if isinstance(word, (str, int)):
            found[constant_name(field, word, found)] = word
    return tuple(found.items())


def _comment(schema: dict[str, Any], left_out: bool, nullable: bool) -> str:
    """Unit, range, format and description, as readable text."""
    unit = schema.get("unit")
    ranges = [f"{sign} {schema[word]:g}" for word, sign in RANGES.items() if word in schema]
    shape = [f"{schema['format']}"] if "format" in schema else []
    shape += [f"matches {schema['pattern']}"] if "pattern" in schema else []
    parts = [str(schema.get("description", "")), f"in {unit}" if unit else "", ", ".join(ranges)]
    parts += [*shape, "may be left out" if left_out else "", "may be unknown" if nullable else ""]
    return "; ".join(" ".join(part.split()) for part in parts if part)
