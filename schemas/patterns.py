"""Regular expressions that end, whatever the pattern and the text: matched by RE2 in linear time.

Python's own matcher takes for ever with a pattern such as `(a+)+$`. RE2 has no look-ahead, look-behind or
back-reference, and its `\\w`, `\\d` and `\\b` mean ASCII, as in JSON Schema and on the page.
"""

from collections.abc import Collection, Iterator, Mapping
from functools import cache, cached_property
from typing import Any

from .quantity import is_number

ANNOTATIONS = (
    "unit",
    "computed_from",
    "title",
    "description",
    "default",
    "examples",
    "deprecated",
    "readOnly",
    "writeOnly",
    "contentMediaType",
)
"""Keywords of a value's schema that nothing is checked by."""


TYPES = ("number", "integer", "string", "boolean", "array", "object", "null")


def schema_fault_words(fault: Any) -> str:
    """What is wrong in a JSON Schema, of jsonschema's SchemaError, for who wrote it."""
    path, value = list(fault.absolute_path), fault.instance
    if path[-1:] == ["type"]:
        return f"{value!r} is not one of {', '.join(TYPES)}"
    if path[-1:] in (["minimum"], ["maximum"]) and isinstance(value, str):
        return f"{value!r} is not a bare number, in the unit that stands beside it"
    return str(fault.message)


def ranges_of_nothing(
    schema: Any, path: tuple[str | int, ...] = ()
) -> Iterator[tuple[tuple[str | int, ...], str]]:
    """Where a minimum is above its maximum, or what is required is no property: nothing ever fits."""
    if isinstance(schema, dict):
        low, high = schema.get("minimum"), schema.get("maximum")
        if is_number(low) and is_number(high) and low > high:
            yield (*path, "minimum"), f"the minimum {low} is above the maximum {high}"
        known: Any = schema.get("properties")
        for index, name in enumerate(schema.get("required", []) if isinstance(known, dict) else ()):
            if name not in known:
                said = f"{name!r} is required, and not among the properties: {', '.join(known) or 'none'}"
                yield (*path, "required", index), said
        for key, inner in schema.items():
            yield from ranges_of_nothing(inner, (*path, key))
    elif isinstance(schema, list):
        for index, inner in enumerate(schema):
            yield from ranges_of_nothing(inner, (*path, index))


class PatternFault(ValueError):
    """A pattern that cannot be used; the message says why."""


@cache
def regular_expression(pattern: str) -> Any:
    """The compiled pattern, with `search(text)`; raises PatternFault."""
    import re2

    options = re2.Options()
    options.log_errors = False
    try:
        return re2.compile(pattern, options)
    except re2.error as fault:
        raise PatternFault(_why(fault)) from fault


def _why(fault: Exception) -> str:
    reason = (
        fault.args[0].decode(errors="replace") if isinstance(fault.args[0], bytes) else str(fault)
    )
    looks = (
        reason.startswith("invalid perl operator: (?") or "invalid escape sequence: \\" in reason
    )
    what = "; look-ahead, look-behind and back-references are not supported" if looks else ""
    return f"{reason}{what}"


class Validator:
    """The rules of a JSON Schema (draft 2020-12), with patterns that end.

    jsonschema, which takes long to import, is asked about whatever is not plainly right.
    """

    def __init__(self, schema: Mapping[str, Any]) -> None:
        self.schema = schema

    def is_valid(self, value: Any) -> bool:
        """Whether the value keeps the schema."""
        return plainly_right(self.schema, value) or self._draft.is_valid(value)

    def iter_errors(self, value: Any) -> Iterator[Any]:
        """Every jsonschema.ValidationError of the value."""
        return iter(()) if plainly_right(self.schema, value) else self._draft.iter_errors(value)

    @cached_property
    def _draft(self) -> Any:
        return _draft()(self.schema)


def validator(schema: Mapping[str, Any]) -> Validator:
    """The validator of a JSON Schema."""
    return Validator(schema)


SAYS_NOTHING = {*ANNOTATIONS, "summary", "format"}
KINDS = {
    "number": is_number,
    "integer": lambda value: type(value) is int,
    "string": lambda value: isinstance(value, str),
    "boolean": lambda value: isinstance(value, bool),
    "object": lambda value: isinstance(value, dict),
    "array": lambda value: isinstance(value, list),
}
RULES = {
    "type": lambda value, wanted, _: isinstance(wanted, str) and KINDS.get(wanted, _never)(value),
    "minimum": lambda value, least, _: is_number(value) and value >= least,
    "maximum": lambda value, most, _: is_number(value) and value <= most,
    "exclusiveMinimum": lambda value, least, _: is_number(value) and value > least,
    "exclusiveMaximum": lambda value, most, _: is_number(value) and value < most,
    "enum": lambda value, known, _: isinstance(value, str) and value in known,
    "pattern": lambda value, wanted, _: (
        isinstance(value, str) and regular_expression(wanted).search(value) is not None
    ),
    "items": lambda value, each, _: (
        isinstance(value, list) and all(plainly_right(each, item) for item in value)
    ),
    "required": lambda value, names, _: isinstance(value, dict) and value.keys() >= {*names},
    "minProperties": lambda value, least, _: isinstance(value, dict) and len(value) >= least,
    "properties": lambda value, known, _: (
        isinstance(value, dict)
        and all(plainly_right(known[name], item) for name, item in value.items() if name in known)
    ),
    "additionalProperties": lambda value, others, schema: (
        isinstance(value, dict)
        and (others is True or (others is False and value.keys() <= schema.get("properties", {}).keys()))
    ),
}  # fmt: skip


def plainly_right(schema: Any, value: Any) -> bool:
    """True only for a value that keeps a schema of RULES; False for what has to be looked at closely."""
    return isinstance(schema, Mapping) and all(
        key in SAYS_NOTHING or (key in RULES and RULES[key](value, said, schema))
        for key, said in schema.items()
    )


def _never(_: Any) -> bool:
    return False


def check_schema(schema: Mapping[str, Any]) -> None:
    """Raise jsonschema.SchemaError for what is no JSON Schema, and for a pattern that cannot be used."""
    from jsonschema import SchemaError

    draft = _draft()
    try:
        draft.check_schema(schema, format_checker=draft.FORMAT_CHECKER)
    except SchemaError as fault:
        if isinstance(fault.cause, PatternFault):
            fault.message = f"{fault.instance!r} is not a pattern that can be used: {fault.cause}"
        raise


def unknown_keywords(
    schema: Mapping[str, Any], own: Collection[str] = ()
) -> Iterator[tuple[tuple[str, ...], list[str]]]:
    """(path, keys that are known there) of each key that would do nothing, such as `minimun: 0`."""
    known = [*_draft().VALIDATORS, *ANNOTATIONS, *own]
    for key in schema:
        if key not in known and not key.startswith(("$", "x-")):
            yield (key,), known
    named = dict(schema.get("properties", {})).items()
    for path, one in [(("properties", n), s) for n, s in named] + [
        (("items",), schema.get("items"))
    ]:
        if isinstance(one, Mapping):
            yield from (((*path, *rest), keys) for rest, keys in unknown_keywords(one, own))


@cache
def _draft() -> Any:
    from jsonschema import Draft202012Validator, FormatChecker, ValidationError, validators

    def pattern(_: Any, wanted: str, text: Any, __: Any) -> Iterator[ValidationError]:
        if isinstance(text, str) and not regular_expression(wanted).search(text):
            yield ValidationError(f"{text!r} does not match {wanted!r}")

    formats = FormatChecker(())

    @formats.checks("regex", raises=PatternFault)
    def usable(wanted: object) -> bool:
        return not isinstance(wanted, str) or bool(regular_expression(wanted))

    return validators.extend(Draft202012Validator, {"pattern": pattern}, format_checker=formats)
