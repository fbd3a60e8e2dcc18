"""What is sent, with the parameters put in: `VOLT:RANG {range:g}`, `OUTP {on:ON|OFF}`, `{{`."""

from collections.abc import Callable, Iterator, Mapping
from string import Formatter
from typing import Any

from ..driver import ActionFailed
from .answers import words_of
from .config import WHOLE, typed
from .number_forms import FORMS, formed

GOAL = "goal"
"""The placeholder of the goal's id, for an instrument that can keep a text beside what it did."""


def template_faults(text: str, params: Mapping[str, Any]) -> Iterator[str]:
    """What is wrong with a text that is sent, for parameters of these JSON Schemas."""
    try:
        parts = list(Formatter().parse(text))
    except ValueError as fault:
        yield f"{text!r}: {fault}; a brace that is sent is written twice: {{{{"
        return
    for _, name, spec, conversion in parts:
        if name is None:
            continue
        if name not in params and name != GOAL:
            known = ", ".join(params) or "none"
            yield f"{{{name}}}: the action has no parameter {name!r}; its parameters: {known}"
        elif conversion or "{" in (spec or ""):
            yield f"{{{name}}}: only a format may follow the name, such as {{{name}:.3f}}"
        elif found := set(FORMS) & set(params.get(name, {})):
            if spec:
                yield f"{{{name}:{spec}}}: `{min(found)}` says how it is sent; no format follows the name"
        else:
            try:
                schema = params.get(name, {"type": "string"})
                _put(written(_sample(schema), schema, spec or ""), spec or "", name)
            except (ValueError, TypeError) as fault:
                yield f"{{{name}:{spec}}}: {fault}"


def fill(
    text: str, given: Mapping[str, Any], params: Mapping[str, Any], goal: str, decimal: str = ".",
    *, escape: Callable[[str], str] = str,
) -> str:  # fmt: skip
    """The text as it is sent, each value in it by `escape`; a parameter that is not given has its default.

    Raises ActionFailed (Rejected) for a text with control characters: it would be a second command.
    """
    made = []
    for literal, name, spec, _ in Formatter().parse(text):
        made.append(literal)
        if name is None:
            continue
        schema = params.get(name, {})
        value = (
            goal if name == GOAL and name not in params else given.get(name, schema.get("default"))
        )
        try:
            value = written(_of_kind(value, schema), schema, spec or "")
            put = _put(value, spec or "", name)
        except (ValueError, TypeError) as fault:  # one that may be left out, and was
            raise ActionFailed("Rejected", f"{name}: {fault}; nothing was sent", "no") from fault
        if isinstance(value, float):
            put = put.replace(".", schema.get("decimal", decimal))
        control = any(ord(sign) < 32 or ord(sign) == 127 for sign in put)
        if control and "bytes" not in schema:
            raise ActionFailed(
                "Rejected", f"{name}: {put!r} has control characters; nothing was sent", "no"
            )
        made.append(escape(put))
    return "".join(made)


def _of_kind(value: Any, schema: Mapping[str, Any]) -> Any:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return value
    return int(value) if schema.get("type") == "integer" else float(value)


def written(value: Any, schema: Mapping[str, Any], spec: str) -> Any:
    """As the instrument writes it: its own word, or its own number, (value - offset) / scale; as bytes."""
    if set(FORMS) & set(schema) and value is not None:
        decimal = {key: one for key, one in schema.items() if key not in FORMS}
        made = written(value, decimal, spec)
        numbers = made if isinstance(made, (list, tuple)) else [made]
        return "".join(
            formed(float(one) if isinstance(one, str) else one, schema) for one in numbers
        )
    if "words" in schema:
        return words_of(schema).get(value, value)
    if not {"scale", "offset"} & set(schema) or isinstance(value, (bool, str)) or value is None:
        return value
    if isinstance(value, (list, tuple)):
        return [written(one, schema, spec) for one in value]
    number = float(f"{(value - schema.get('offset', 0)) / schema.get('scale', 1):.12g}")
    return round(number) if spec[-1:] in tuple("bcdoxX") else number


def _put(value: Any, spec: str, name: str) -> str:
    if isinstance(value, (list, tuple)):
        return ",".join(_put(one, spec, name) for one in value)
    if isinstance(value, bool):
        yes, bar, no = spec.partition("|")
        return (yes if value else no) if bar else format(int(value), spec)
    if value is None:
        raise ValueError(f"{name} has no value")
    return format(value, spec or (".12g" if isinstance(value, float) else ""))


def _sample(schema: Mapping[str, Any]) -> Any:
    if schema.get("enum"):
        return _of_kind(schema["enum"][0], schema)
    kind = typed(dict(schema))["type"]
    kind = kind[0] if isinstance(kind, list) else kind
    samples = {"number": 1.5, "integer": 1, "boolean": True, "array": [1.5]}
    return samples.get(kind, "x")


def filled(data: Any, given: Mapping[str, Any], params: Mapping[str, Any], goal: str) -> Any:
    """Data with the parameters put in: "{speed}" alone is the value itself, not its text."""
    if isinstance(data, dict):
        return {name: filled(value, given, params, goal) for name, value in data.items()}
    if isinstance(data, list):
        return [filled(value, given, params, goal) for value in data]
    if not isinstance(data, str):
        return data
    whole = WHOLE.fullmatch(data)
    if whole and whole[1] in params:
        schema = params[whole[1]]
        return written(given.get(whole[1], schema.get("default")), schema, "")
    return fill(data, given, params, goal)


def texts(key: str, data: Any) -> Iterator[tuple[str, str]]:
    """(key, text) of every text in data."""
    if isinstance(data, str):
        yield key, data
    for value in (
        data.values() if isinstance(data, dict) else data if isinstance(data, list) else ()
    ):
        yield from texts(key, value)
