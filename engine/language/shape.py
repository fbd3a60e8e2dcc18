"""Translate pydantic's validation errors into problems at their places."""

import re
import unicodedata
from collections.abc import Iterable, Mapping, Sized
from typing import Any, get_args, get_origin

from pydantic import BaseModel, ValidationError

from ...schemas.lab import Lab
from ...schemas.problem import Problem
from ...schemas.protocol import STEP_KINDS, STEP_LISTS, Group, StepBase
from ...schemas.quantity import QUANTITY
from .operators import words
from .source import Source
from .suggest import INSTEAD, MEANT, closest, did_you_mean, listed
from .yaml_characters import odd_characters
from .yaml_traps import NO_BRACKETS

CODES = {
    "E110": "an unknown key",
    "E111": "a missing key",
    "E112": "a value of the wrong type or form",
    "E113": "a part of the file that is not the mapping or list that it should be",
    "E114": "a step without a keyword that says what it does",
    "E115": "a step with two keywords",
    "E117": "a version of the protocol language that this labrun does not support",
}

WANTED = {
    "string_type": "text",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "float_type": "a number",
    "bool_type": "true or false",
    "dict_type": "keys with values",
    "model_type": "keys with values",
    "model_attributes_type": "keys with values",
    "list_type": "a list",
    "none_required": "nothing",
}
NAME = "a name of letters (a to z), digits and _ that begins with a letter"
PROTOCOL_NAME = "a name of letters (a to z), digits, spaces, _ . and -"
FORMS = {
    r"^[A-Za-z][A-Za-z0-9_]*$": NAME,
    r"^[A-Za-z_][A-Za-z0-9_]*$": NAME,
    r"^[a-z][a-z0-9_]*@[0-9]+$": "a contract with its version, such as gantry@1",
    r"^[A-Za-z][A-Za-z0-9_]*\.[A-Za-z_][A-Za-z0-9_]*$": "role.action, such as gantry.home",
    r"^[A-Za-z0-9][A-Za-z0-9 _.-]*$": PROTOCOL_NAME,
    r"^https?://[^/\s]+/?$": "an address such as http://10.0.0.7:4101",
    r"^(([01]\d|2[0-3]):[0-5]\d)?$": "a time of day such as 07:00",
    r"^[a-z](_?[a-z0-9]+)*$": "a name of small letters, digits and _ such as labrun_interfaces",
}
WRITTEN = {
    "devices": "such as devices: {gantry: gantry@1}",
    "params": "such as params: {depth: {type: quantity, unit: mm, default: 2 mm}}",
    "foreach": "such as foreach: {x: [1 mm, 2 mm]}",
    "with": "such as with: {x: 1 mm}",
    "set": "such as set: {depth: 1 mm}",
    "collect": 'such as collect: {mass: "${{ steps.weight.mass }}"}',
    "outputs": 'such as outputs: {mass: "${{ steps.weight.mass }}"}',
    "wait": "such as wait: 30 s",
    "functions": "such as functions: {mean_area: ./analysis.py:mean_area}",
    "at_once": "such as at_once: 3",
    "keep_going": "such as keep_going: {in_a_row: 3}",
    "retry": "such as retry: 3",
    "until": "such as until: {do: state, busy: false}",
    "repeat": "such as repeat: 3; `while: ${{ ... }}` repeats as long as a condition holds",
    "on_error": "such as on_error: continue; `retry: {attempts: 3, on: [Timeout]}` tries again after these",
    "choices": "such as choices: [good, bad]",
    "confirm": "such as confirm: The door is closed",
    "watch": 'such as watch: [{when: "${{ status.floor.wet }}", then: pause}]',
}
"""How what is often written otherwise is written."""
SPELT = str.maketrans(
    {
        "ä": "ae",
        "ö": "oe",
        "ü": "ue",
        "Ä": "Ae",
        "Ö": "Oe",
        "Ü": "Ue",
        "ß": "ss",
        "ø": "o",
        "æ": "ae",
    }
)
OF_STEPS = {*STEP_LISTS, "fallback", "on_resume", "finally"}
OF_NAMES = ("devices", "params", "outputs", "functions")
"""Sections whose keys are names."""
OF_GROUPS = Group.model_fields.keys() - StepBase.model_fields.keys() - {"steps"}
Place = tuple[str | int, ...]
Found = dict[Place, list[dict[str, Any]]]
"""The errors of pydantic at each place."""


def keys_of(model: type[BaseModel]) -> list[str]:
    """The keys that a model has in YAML."""
    return [field.alias or name for name, field in model.model_fields.items()]


OF_KEY = re.compile(r"(?:\w+: )?(\w+): ")


def read_model(
    model: type[BaseModel], data: Any, source: Source, place: Place, what: str
) -> tuple[Any, list[Problem]]:
    """The model of some data, or None, and the problems found."""
    if not isinstance(data, dict):
        message = f"{what} is written as keys with values, not as {kind_words(data)}"
        return None, [source.problem(place, "E113", message)]
    try:
        return model.model_validate(data), []
    except ValidationError as fault:
        return None, list(shape_problems(fault, model, data, source, place))


def shape_problems(
    fault: ValidationError, model: type[BaseModel], data: Any, source: Source, place: Place
) -> Iterable[Problem]:
    """One problem for each place where pydantic found an error."""
    found: Found = {}
    for error in fault.errors(include_url=False):
        path = _real_path(error["loc"], data, missing=error["type"] == "missing")
        found.setdefault(path, []).append(dict(error))
    told: set[int] = set()
    found = _without_consequences(found, data)
    deeper = {path[:n] for path in found for n in range(len(path))}
    unknown = [path for path, errors in found.items() if errors[0]["type"] == "extra_forbidden"]
    beside = _parameters_beside(model, unknown)
    for path, errors in found.items():
        if path in beside[1:]:
            continue  # told with the first
        if errors[0]["type"] == "missing" and _misspelt(path, unknown):
            continue
        # In a union, the branch that looked inside is more precise than those that rejected it all.
        union_refusals = path in deeper and all(e["type"] in WANTED for e in errors)
        if union_refusals:
            continue
        problem = _problem(path, errors, model, data, source, place, [str(p[-1]) for p in beside])
        if problem.hint == NO_BRACKETS:  # told once for `1, 2, 3`
            if problem.line in told:
                continue
            told.add(problem.line)
        yield problem


def _parameters_beside(model: type[BaseModel], unknown: list[Place]) -> list[Place]:
    """Unknown keys of an action that are like none of its keys: parameters that belong under `with`."""
    allowed = keys_of(model)
    if "with" not in allowed:
        return []
    return [path for path in unknown if len(path) == 1 and closest(str(path[0]), allowed) is None]


def _without_consequences(found: Found, data: Any) -> Found:
    """Without the keys that stand beside an empty one because they are not indented below it.

    Where such a key holds an odd space, that is the reason, and the empty one is left out.
    """
    for path in list(found):
        value, above = at(data, path), at(data, path[:-1])
        if (
            value is not None
            or path not in found  # with one further up
            or not path
            or not isinstance(above, dict)
            or not _needs_more(found[path])
        ):
            continue
        after = list(above)[list(above).index(path[-1]) + 1 :] if path[-1] in above else []
        beside = [(*path[:-1], key) for key in after if (*path[:-1], key) in found]
        odd = any(odd_characters(str(other[-1])) for other in beside)
        for other in [path] if odd else beside:
            found = {
                place: errors for place, errors in found.items() if place[: len(other)] != other
            }
    return found


def _needs_more(errors: list[dict[str, Any]]) -> bool:
    """True where keys or a list are wanted."""
    wanted = {WANTED.get(error["type"]) for error in errors}
    return bool(wanted) and wanted <= {"keys with values", "a list"}


def _holds(node: Any, part: Any) -> bool:
    if isinstance(node, list):
        return isinstance(part, int) and part < len(node)
    return isinstance(node, dict) and part in node


def _misspelt(path: Place, unknown: list[Place]) -> bool:
    """True where a missing key is only misspelt, which is already reported."""
    beside = [str(other[-1]) for other in unknown if other[:-1] == path[:-1]]
    return any(closest(name, [str(path[-1])]) for name in beside)


def _real_path(location: tuple[Any, ...], data: Any, *, missing: bool) -> Place:
    """pydantic's location without the names of union branches."""
    path: list[str | int] = []
    node = data
    for index, part in enumerate(location):
        if _holds(node, part):
            node = node[part]
        elif missing and index == len(location) - 1:
            path.append(part)
            break
        else:
            continue
        path.append(part)
    return tuple(path)


def _problem(
    path: Place, errors: list[dict[str, Any]], model: type[BaseModel], data: Any,
    source: Source, place: Place, beside: list[str],
) -> Problem:  # fmt: skip
    kinds = [error["type"] for error in errors]
    name = _name(path)
    if "extra_forbidden" in kinds:
        allowed = _allowed(model, path[:-1])
        if model is Lab and path[:1] == ("devices",) and len(path) == 3 and name in keys_of(Lab):
            message = f"unknown key {name!r}: it belongs to the lab, not to one device"
            hint = f"write `{name}` in the first column, beside `devices`"
            return source.problem((*place, *path), "E110", message, hint, key=True)
        if name in OF_GROUPS and issubclass(model, StepBase) and len(path) == 1:
            message = f"unknown key {name!r}: it belongs to a group"
            hint = f"put a group around this step: `steps: [...]` with `{name}`"
            return source.problem((*place, *path), "E110", message, hint, key=True)
        of_step = issubclass(model, StepBase) and len(path) == 1
        instead = INSTEAD.get(name.casefold()) if of_step else None
        of = [kind.KIND for kind in STEP_KINDS if of_step and name in keys_of(kind)]
        message = f"unknown key {name!r}{did_you_mean(name, allowed)}"
        if instead:
            return source.problem(
                (*place, *path), "E110", f"unknown key {name!r}", instead, key=True
            )
        if of and name.casefold() not in MEANT:
            message = f"unknown key {name!r}: it belongs to a step with {listed(of, last='or')}"
        elif where := _elsewhere(model, path):
            message = f"unknown key {name!r}: {where}"
        if len(beside) > 1 and name == beside[0]:
            message = f"unknown keys {listed(repr(key) for key in beside)}"
        hint = f"allowed here: {', '.join(allowed)}" if allowed else ""
        hint += "; an action's own parameters go under `with`" if "with" in allowed else ""
        hint += "; what its driver needs goes under `config`" if "config" in allowed else ""
        return source.problem((*place, *path), "E110", message, hint, key=True)
    if "missing" in kinds:
        around = (*place, *path[:-1])
        message, way = f"the key {name!r} is missing", WRITTEN.get(name, "")
        if model is Lab and path == ("devices",):
            way = _way_on_in_lab(path, message, None)
        return source.problem(around, "E111", message, way, key=bool(path[:-1]))
    value = at(data, path)
    message = _says(name, errors, value).removeprefix(": ")
    at_key = any("[key]" in str(part) for error in errors for part in error["loc"])
    where = (*place, *(part for part in path if part != "[key]"))
    if isinstance(value, dict) and (said := OF_KEY.match(message)) and said[1] in value:
        where = (*where, said[1])  # of keys that do not go together, the one that is told
    way_on = _way_on_in_lab if model is Lab else _way_on
    hint = way_on(path, message, path[-1] if at_key else value)
    return source.problem(where, "E112", message, hint, key=at_key)


def _way_on(path: Place, message: str, value: Any) -> str:
    """What to write in place of a value of the wrong form; or nothing."""
    if not path:  # all of it: two keys that do not go together
        return ""
    if message.endswith(NAME) and isinstance(value, str):
        plain = re.sub(r"[\W_]+", "_", _without_accents(value), flags=re.ASCII).strip("_")
        return f"write {plain}" if re.match(r"[A-Za-z]", plain) else ""
    if message.endswith(PROTOCOL_NAME) and isinstance(value, str):
        plain = re.sub(r"[^\w .-]+", " ", _without_accents(value), flags=re.ASCII).strip(" .-_")
        return f"write {plain}" if plain else ""
    if len(path) == 2 and path[0] in OF_NAMES and path[1] in ("steps", "finally", *OF_NAMES):
        return f"`{path[1]}` belongs to the protocol: write it in the first column"
    if path[-1] == "id" and isinstance(value, int):
        return f"write step_{value}: {NAME}"
    if len(path) == 2 and path[0] == "params" and not isinstance(value, dict | list):
        return f"write {{{_declared(value)}}}" if value is not None else WRITTEN["params"]
    if len(path) == 2 and path[0] == "devices" and isinstance(value, dict):
        return (
            f"name the contract only, such as {path[1]}: gantry@1; the lab says which device it is"
        )
    if isinstance(value, str) and (call := re.match(r"(\w+\.\w+)\s*\(", value)):
        return f"write `do: {call[1]}`, and its parameters under `with`"
    if path == ("foreach",) and isinstance(value, dict) and len(value) > 1:
        return (
            'a loop within the other, or all pairs: foreach: {p: "${{ grid(x=[...], y=[...]) }}"}'
        )
    if path[-1] == "do" and isinstance(value, str):
        action, _, comment = value.partition("#")
        plain = re.sub(r"\s", "", action)
        if comment:
            return "a comment begins with a space and a `#`"
        return f"write `do: {plain}`" if re.fullmatch(r"\w+\.\w+", plain, re.ASCII) else ""
    if path[-1] == "do" and isinstance(value, list):
        return "one action each step; `parallel: [...]` begins several together"
    if path[-1] == "unit" and path[-3:-2] == ("registers",):
        told = f"`returns: {{{path[-2]}: {{unit: {value}}}}}`"
        return f"it is the number of a device on the line; a value has its unit in {told}"
    if path[-2:-1] in (("params",), ("returns",)) and isinstance(value, str):
        kind = {"int": "integer", "float": "number", "str": "string", "bool": "boolean"}.get(
            value, value
        )
        is_type = kind in ("number", "integer", "string", "boolean", "array", "object")
        return f"write {path[-1]}: {{{'type' if is_type else 'unit'}: {kind}}}"
    if "needs a list" in message and isinstance(value, str) and " " not in value.strip():
        is_action = re.fullmatch(r"\w+\.\w+", value.strip()) and path[-1] in OF_STEPS
        return f"write `- do: {value}` below it" if is_action else f"write [{value}]"
    return WRITTEN.get(_name(path), "")


def _without_accents(text: str) -> str:
    """`Größe` as `Groesse`, `étape` as `etape`."""
    spelt = text.translate(SPELT)
    return "".join(c for c in unicodedata.normalize("NFKD", spelt) if not unicodedata.combining(c))


def _way_on_in_lab(path: Place, message: str, value: Any) -> str:
    """What to write in a lab in place of a value of the wrong form; or nothing."""
    match path:
        case ("devices",):
            return "such as devices: {gantry: {contract: gantry@1, driver: sim_gantry}}"
        case ("devices", name) if isinstance(value, str) and not message.endswith(NAME):
            contract = value if "@" in value else "gantry@1"
            return f"such as {name}: {{contract: {contract}, driver: ./driver.py:Driver}}"
        case ("devices", _, "port") if isinstance(value, str) and value.isdigit():
            return f"write {value} without quotes"
        case ("devices", _, "port") if isinstance(value, str):
            return f"what its driver needs goes under `config`: config: {{port: {value}}}"
        case ("devices", _, "limits", "minimum" | "maximum" as bound):
            return f"it is that of a parameter: limits: {{x: {{{bound}: {value}}}}}"
        case ("devices", _, "limits", param):
            return f"such as {param}: {{minimum: 0, maximum: 100}}"
        case ("devices", _, "config"):
            return "such as config: {port: /dev/ttyUSB0}"
        case ("notify",):
            return "such as notify: {to: [mailto://...]}"
        case ("devices", _):
            return "" if isinstance(value, dict) else _way_on(path[1:], message, value)
    return _way_on(path, message, value)


def _declared(value: Any) -> str:
    """The declaration of a parameter of which only the default was written."""
    if isinstance(value, str) and (match := QUANTITY.match(value)):
        return f"type: quantity, unit: {match[2]}, default: {value.strip()}"
    if isinstance(value, str) and re.fullmatch(r"[0-9]+(?:_[0-9]+)+", value):
        value = int(value)  # with marks between its thousands
    kinds = {bool: "boolean", int: "integer", float: "number", str: "string"}
    return f"type: {kinds[type(value)]}, default: {words(value)}"


def _name(path: Place) -> str:
    """How messages name a place: by its key, or as an item of a list."""
    if len(path) > 1 and isinstance(path[-1], int) and isinstance(path[-2], str):
        return f"item {path[-1] + 1} of {path[-2]}"
    return str(path[-1]) if path else ""


def at(data: Any, path: Place) -> Any:
    """The data at a path; None where there is nothing."""
    for part in path:
        try:
            data = data[part]
        except (KeyError, IndexError, TypeError):
            return None
    return data


def _says(name: str, errors: list[dict[str, Any]], value: Any) -> str:
    others = [error for error in errors if error["type"] not in WANTED]
    if not others:
        wanted = dict.fromkeys(WANTED[error["type"]] for error in errors)
        return f"{name or 'this'} needs {' or '.join(wanted)}, not {kind_words(value)}"
    return f"{name}: {_one(others[0])}"


def _one(error: dict[str, Any]) -> str:
    kind, context, value = error["type"], error.get("ctx", {}), error.get("input")
    if kind in ("literal_error", "enum"):
        expected = str(context.get("expected", "")).replace("'", "")
        return f"{kind_words(value)} is not one of {expected}{_guess(value, expected)}"
    if kind == "string_pattern_mismatch":
        form = FORMS.get(context.get("pattern", ""), f"text like {context.get('pattern')}")
        return f"{words(value)} is not {form}"
    if kind == "string_too_short" or (kind == "too_short" and isinstance(value, str)):
        least = context.get("min_length", 1)
        return (
            "it is an empty text" if not value else f"it is too short; at least {least} characters"
        )
    if kind == "too_short":
        return "it is empty; it needs at least one item"
    if kind == "too_long":
        count = len(value) if isinstance(value, Sized) else context.get("actual_length")
        return f"it has {count} items; at most {context.get('max_length')}"
    if kind in ("greater_than_equal", "greater_than"):
        return f"{words(value)} is too small; at least {context.get('ge', context.get('gt'))}"
    if kind in ("less_than_equal", "less_than"):
        return f"{words(value)} is too large; at most {context.get('le', context.get('lt'))}"
    if kind == "string_too_long":
        return f"it is longer than {context.get('max_length')} characters"
    if kind == "value_error":
        return str(context.get("error", error["msg"]))
    return str(error["msg"])


def _guess(value: Any, expected: str) -> str:
    options = expected.replace(" or ", ", ").split(", ")
    return did_you_mean(value, options) if isinstance(value, str) else ""


def _elsewhere(model: type[BaseModel], path: Place) -> str:
    """Where a key belongs that is known further out, or within exactly one of those beside it."""
    for depth in range(len(path) - 2, -1, -1):
        if path[-1] in _allowed(model, path[:depth]):
            return f"it belongs beside `{path[depth]}`"
    fields = getattr(_at(model, path[:-1]), "model_fields", {})
    inner = {name: _model_in(field.annotation) for name, field in fields.items()}
    into = [name for name, one in inner.items() if one and path[-1] in keys_of(one)]
    return f"it belongs into `{into[0]}: {{{path[-1]}: ...}}`" if len(into) == 1 else ""


def _allowed(model: type[BaseModel], path: Place) -> list[str]:
    """The keys allowed at a path inside a model."""
    found = _at(model, path)
    return keys_of(found) if hasattr(found, "model_fields") else []


def _at(model: type[BaseModel], path: Place) -> Any:
    """What is at a path inside a model, by following its fields; None where there is nothing."""
    current: Any = model
    for part in path:
        fields = getattr(current, "model_fields", None)
        if fields is None:
            current = _value_model(current) or current
            continue
        found = next((f for n, f in fields.items() if part in (n, f.alias)), None)
        if found is None:
            return None
        current = found.annotation
        current = _model_in(current) or current
    return _model_in(current) or current


def _model_in(annotation: Any) -> Any:
    """The model that an annotation is or contains as an alternative."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    if get_origin(annotation) in (dict, list):
        return None
    return next((m for a in get_args(annotation) if (m := _model_in(a))), None)


def _value_model(annotation: Any) -> Any:
    """The model of the items of the list, or the values of the keys, that an annotation is or allows."""
    arguments = get_args(annotation)
    if get_origin(annotation) in (dict, list):
        return _model_in(arguments[-1])
    return next((m for a in arguments if (m := _value_model(a))), None)


def kind_words(value: Any) -> str:
    """What a value is, as messages put it."""
    if isinstance(value, Mapping):
        return "keys with values"
    if isinstance(value, list):
        return "a list"
    if value is None:
        return "nothing"
    return words(value)
