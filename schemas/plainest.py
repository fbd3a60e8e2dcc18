"""The simplest value that a JSON Schema allows: what a stand-in answers."""

from typing import Any


def plainest(schema: dict[str, Any], given: Any = None) -> Any:
    """The simplest value that a JSON Schema allows; a value given under that name comes first."""
    if given is not None:
        return given
    for word in ("const", "default", "minimum"):
        if word in schema:
            return schema[word]
    if "enum" in schema:
        return schema["enum"][0]
    kind = schema.get("type", "object")
    kind = kind[0] if isinstance(kind, list) else kind
    match kind:
        case "number" | "integer":
            return min(0, schema.get("maximum", 0))
        case "string":
            return "x"
        case "boolean":
            return False
        case "array":
            return [plainest(schema.get("items", {}))] * schema.get("minItems", 0)
        case "null":
            return None
    return {k: plainest(v) for k, v in schema.get("properties", {}).items()}
