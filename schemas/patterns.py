"""Regular expressions that end, whatever the pattern and the text: matched by RE2 in linear time.

Python's own matcher takes for ever with a pattern such as `(a+)+$`. RE2 has no look-ahead, look-behind or
back-reference, and its `\\w`, `\\d` and `\\b` mean ASCII, as in JSON Schema and on the page.
"""

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any


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


def validator(schema: Mapping[str, Any]) -> Any:
    """The validator of a JSON Schema (draft 2020-12), with patterns that end."""
    return _draft()(schema)


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
