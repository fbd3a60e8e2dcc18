"""Read a protocol's data into models, step by step, so that a broken step does not hide others."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from pydantic import ValidationError

from ...schemas.problem import Problem
from ...schemas.protocol import (
    STEP_KINDS,
    STEP_LISTS,
    LoopBase,
    Protocol,
    StepBase,
    step_kind,
)
from .shape import Place, keys_of, kind_words, shape_problems
from .source import Source
from .suggest import INSTEAD, MEANT, closest, listed
from .yaml_node import shown

KINDS: dict[str, type[StepBase]] = {kind.KIND: kind for kind in STEP_KINDS}
ANYWHERE = set(keys_of(StepBase))
EVERY_KEY = {key for kind in STEP_KINDS for key in keys_of(kind)}
OF_PROTOCOLS = set(keys_of(Protocol)) - EVERY_KEY
SECTIONS = ("steps", "on_resume", "finally")
SAID = re.compile(r"(?:(do)\s+)?([A-Za-z]\w*\.\w+)\s*(\(.*\))?", re.DOTALL)
"""A step that is only text: an action, perhaps with `do` before it or called like a function."""
ASSIGNED = re.compile(r"([A-Za-z]\w*) *= *([A-Za-z]\w*\.\w+) *(?:\(.*\))?", re.DOTALL)
EQUALS = re.compile(r"(\w+)\s*=\s*(.+)")
STAND_IN = {"log": "-"}
INSIDE = {"foreach": "steps", "repeat": "steps", "while": "steps", "reserve": "steps", "if": "then"}
"""Where a step of this kind has what it does: people put an action beside it."""
FOR_IN = re.compile(r"for(?:each)?(?: each)?\s+(\w+)\s+in\s+(.+)", re.DOTALL)
ACTION = re.compile(r"[A-Za-z]\w*\.\w+")


class Broken(StepBase):
    """A placeholder for a step that could not be read, so that the others keep their places."""

    KIND: ClassVar[str] = "broken"


@dataclass(slots=True)
class Loaded:
    """A protocol as far as it could be read; `whole` if nothing is missing."""

    protocol: Protocol
    whole: bool


def read_protocol(source: Source) -> tuple[Loaded | None, list[Problem]]:
    """The protocol of a file, and all problems with its keys and values."""
    data = source.data
    if not isinstance(data, dict):
        message = f"a protocol is written as keys with values, not as {kind_words(data)}"
        return None, [source.problem((), "E113", message, "it begins with `labrun: 1`")]
    if _is_lab(data):
        message, hint = (
            "this is a lab file, not a protocol",
            "give it together with a protocol, as `--lab`; `labrun devices --lab FILE` checks it alone",
        )
        return None, [source.problem((), "E113", message, hint)]
    if strangers := _foreign(data):
        message = "this is not a protocol: it has neither `labrun` nor `steps`"
        hint = f"a protocol begins with `labrun: 1`; this file has {listed(strangers, 4)}"
        return None, [source.problem((), "E113", message, hint)]
    problems: list[Problem] = list(_version(data, source))
    sections: dict[str, list[Any]] = {}
    for name in SECTIONS:
        if isinstance(data.get(name), list):
            sections[name] = _steps(data[name], source, (name,), problems)
        elif step_kind(data.get(name)) is not None:
            sections[name] = _lone_step(data[name], source, (name,), problems)
    frame = _frame(data, source, problems)
    update = {
        ("finally_" if name == "finally" else name): steps for name, steps in sections.items()
    }
    if "steps" not in sections:
        update["steps"] = []
    protocol = frame.model_copy(update=update)
    return Loaded(protocol, whole=not problems), problems


def _is_lab(data: dict[str, Any]) -> bool:
    """True for a lab: its devices are mappings with a contract or driver, those of a protocol contracts."""
    devices = data.get("devices")
    named = devices.values() if isinstance(devices, dict) else ()
    if "labrun" in data or "steps" in data or not named:
        return False
    return all(
        isinstance(device, dict) and {"contract", "driver"} & set(device) for device in named
    )


def _foreign(data: dict[str, Any]) -> list[str]:
    """The keys of a file of another program: no protocol has them, and nothing says that it is one."""
    unknown = [key for key in data if key not in keys_of(Protocol)]
    meant = any(key.casefold() == "labrun" or closest(key, ("steps",)) for key in data)
    return unknown if len(unknown) > 1 and not meant else []


def _version(data: dict[str, Any], source: Source) -> Iterator[Problem]:
    if "labrun" not in data and any(closest(key, ("labrun",)) for key in data):
        return  # told as an unknown key
    if "labrun" not in data:
        yield source.problem(
            (), "E111", "the key 'labrun' is missing", "a protocol begins with `labrun: 1`"
        )
    elif data["labrun"] != 1 or isinstance(data["labrun"], bool):
        message = f"this labrun reads version 1 of the protocol language, not {kind_words(data['labrun'])}"
        yield source.problem(("labrun",), "E117", message, "write `labrun: 1`")


def _frame(data: dict[str, Any], source: Source, problems: list[Problem]) -> Protocol:
    """Everything but the steps; what is broken is reported and left out."""
    rest = {**data, "labrun": 1}
    for name in SECTIONS:
        held = rest.get(name)
        if step_kind(held) is not None or (isinstance(held, list) and (held or name != "steps")):
            rest[name] = [STAND_IN]
    try:
        return Protocol.model_validate(rest)
    except ValidationError as fault:
        problems += shape_problems(fault, Protocol, rest, source, ())
        for error in fault.errors(include_url=False, include_context=False):
            _leave_out(rest, error["loc"])
    rest.setdefault("name", "protocol")
    rest.setdefault("steps", [STAND_IN])
    try:
        return Protocol.model_validate(rest)
    except ValidationError:
        return Protocol.model_validate({"labrun": 1, "name": "protocol", "steps": [STAND_IN]})


def _leave_out(rest: dict[str, Any], location: tuple[Any, ...]) -> None:
    first = location[0]
    inner = rest.get(first)
    if (
        first in ("params", "devices", "functions", "outputs", "defaults")
        and len(location) > 1
        and isinstance(inner, dict)
    ):
        rest[first] = {key: value for key, value in inner.items() if key != location[1]}
    else:
        rest.pop(first, None)


# --- steps


def _steps(items: list[Any], source: Source, place: Place, problems: list[Problem]) -> list[Any]:
    return [_step(item, source, (*place, index), problems) for index, item in enumerate(items)]


def _lone_step(
    data: dict[str, Any], source: Source, place: Place, problems: list[Problem]
) -> list[Any]:
    """A single step in place of a list of steps: reported, and read anyway."""
    hint = "put `- ` before it, and indent what follows: even a single step must be in a list"
    message = f"{place[-1]} needs a list, not {kind_words(data)}"
    problems.append(source.problem(place, "E112", message, hint))
    return [_step(data, source, place, problems)]


def _step(data: Any, source: Source, place: Place, problems: list[Problem]) -> StepBase:
    if not isinstance(data, dict) or not data:
        problems.append(_no_mapping(data, source, place))
        return Broken.model_construct()
    kind, refusal = _kind(data, source, place)
    if refusal is not None:
        problems.append(refusal)
    if kind is None:
        return _broken(data)
    return _read(kind, data, source, place, problems)


def _no_mapping(data: Any, source: Source, place: Place) -> Problem:
    if data is None or data == {}:
        return source.problem(
            place, "E113", "an empty step", "remove it, or write `do: role.action`"
        )
    hint = "write `do: role.action`"
    if isinstance(data, list):
        hint = (
            "remove one of the two dashes; steps that belong together are a group: `- steps: [...]`"
        )
    if data in ("break", "continue", "exit"):
        hint = "a loop ends when its `while:` is false; what is left out stands under an `if:`"
    if data == "pause":
        hint = "a run is paused by a watch, `then: pause`, or by `on_error: pause`"
    elif isinstance(data, str) and (said := SAID.fullmatch(data.strip())):
        keyword, action, call = said.groups()
        hint = f"write `do: {action}`" + (", and its parameters under `with`" if call else "")
        hint = f"a colon is missing: `{keyword}: {action}`" if keyword else hint
    elif isinstance(data, str) and (said := EQUALS.fullmatch(data.strip())) and said[1] in KINDS:
        hint = f"a key and its value have a colon between them: `{said[1]}: {shown(said[2])}`"
    elif isinstance(data, str) and (said := ASSIGNED.fullmatch(data.strip())):
        hint = f"write `{{id: {said[1]}, do: {said[2]}}}`; its result is steps.{said[1]}"
    elif isinstance(data, str) and (begun := data.partition(" ")[0]) in KINDS and " " in data:
        hint = f"a colon is missing: `{begun}: {shown(data.partition(' ')[2])}`"
    return source.problem(
        place, "E113", f"a step is a mapping with a keyword, not {kind_words(data)}", hint
    )


def _kind(
    data: dict[str, Any], source: Source, place: Place
) -> tuple[type[StepBase] | None, Problem | None]:
    """The kind of step, from its keyword; a problem if there is none, or more than one."""
    found = [key for key in data if key in KINDS]
    if len(found) > 1 and "steps" in found and any(issubclass(KINDS[k], LoopBase) for k in found):
        found.remove("steps")
    if not found:
        return None, _no_keyword(data, source, place)
    if len(found) > 1:
        message = f"a step has one keyword; this one has {listed(f'`{name}`' for name in found)}"
        hint = "make it two steps, or a group: `steps: [...]`"
        around = next((name for name in found if name in INSIDE), None)
        if inside := INSIDE.get(found[0]):
            hint = f"what it does goes below it, under `{inside}:`"
        elif around == "if":
            hint = "the condition of one step is its `when:`"
        elif around is not None:
            hint = f"a step with `{around}` has the others below it, under `{INSIDE[around]}:`"
        return None, source.problem((*place, found[1]), "E115", message, hint, key=True)
    return _beside(KINDS[found[0]], data, source, place)


def _beside(
    kind: type[StepBase], data: dict[str, Any], source: Source, place: Place
) -> tuple[type[StepBase] | None, Problem | None]:
    """The kind, unless another key is a misspelt keyword, such as `for_each:`."""
    allowed = keys_of(kind)
    for key in data:
        near = closest(key, KINDS) if key not in EVERY_KEY else None
        if near not in (None, kind.KIND) and closest(key, allowed) is None:
            message = f"unknown keyword {key!r}; did you mean {near}?"
            return None, source.problem((*place, key), "E114", message, key=True)
    return kind, None


def _no_keyword(data: dict[str, Any], source: Source, place: Place) -> Problem:
    for key in data:
        if key not in ANYWHERE and key != "with":
            near = closest(key, KINDS)
            message = f"unknown keyword {key!r}" + (f"; did you mean {near}?" if near else "")
            hint = f"a step has one of {', '.join(KINDS)}"
            if instead := INSTEAD.get(key.casefold()):
                message, hint = f"unknown keyword {key!r}", instead
            elif key in OF_PROTOCOLS:
                hint = (
                    f"`{key}` belongs to the protocol: write it in the first column, beside `steps`"
                )
            elif near == "use" and ACTION.fullmatch(str(data[key]).strip()):
                message, hint = f"unknown keyword {key!r}", f"write `do: {data[key].strip()}`"
            elif begun := _with_its_keyword(key):
                hint = begun
            elif ACTION.fullmatch(key):
                message = f"an action is named by `do`, not as the key {key!r}"
                hint = f"write `do: {key}`, and its parameters under `with`"
            elif near is None and (said := SAID.fullmatch(str(data[key]).strip())):
                hint = f"write `{{id: {key}, do: {said[2]}}}`; its result is steps.{key}"
            elif key == "device" and isinstance(data[key], str):
                hint = f"write `do: {data[key]}.{data.get('action', 'action')}`"
            if of := [name for name, kind in KINDS.items() if key in keys_of(kind)]:
                message = "this step has no keyword that says what it does"
                hint = f"`{key}` belongs to a step with {listed(of, last='or')}"
            return source.problem((*place, key), "E114", message, hint, key=True)
    message = "this step has no keyword that says what it does"
    return source.problem(place, "E114", message, f"give it one of {', '.join(KINDS)}")


def _with_its_keyword(key: str) -> str:
    """The hint for a keyword and what follows it as one key, as other languages have it; or nothing."""
    if match := FOR_IN.fullmatch(key):
        return f'write `foreach: {{{match[1]}: "${{{{ {match[2]} }}}}"}}`, and `steps:` below it'
    word, _, rest = key.partition(" ")
    keyword = word if word in KINDS else MEANT.get(word.casefold(), "")
    if not rest or keyword not in KINDS:
        return ""
    value = f"${{{{ {rest} }}}}" if keyword in ("if", "while", "require") else rest
    below = f", and `{INSIDE[keyword]}:` below it" if keyword in INSIDE else ""
    return f"write `{keyword}: {shown(value)}`{below}"


def _read(
    kind: type[StepBase],
    data: dict[str, Any],
    source: Source,
    place: Place,
    problems: list[Problem],
) -> StepBase:
    inner: dict[str, list[Any]] = {}
    rest = dict(data)
    for name, field in {**STEP_LISTS, "fallback": "fallback"}.items():
        if isinstance(data.get(name), list) and data[name] and name in keys_of(kind):
            read = _alternatives if name == "fallback" else _steps
            inner[field] = read(data[name], source, (*place, name), problems)
            rest[name] = [STAND_IN]
        elif step_kind(data.get(name)) is not None and name in keys_of(kind):
            inner[field] = _lone_step(data[name], source, (*place, name), problems)
            rest[name] = [STAND_IN]
    if isinstance(data.get("watch"), list) and "watch" in keys_of(kind):
        rest["watch"], thens = _watches(data["watch"], source, (*place, "watch"), problems)
    else:
        thens = []
    try:
        step = kind.model_validate(rest)
    except ValidationError as fault:
        problems += shape_problems(fault, kind, rest, source, place)
        faulty = {
            error["loc"][0] for error in fault.errors(include_url=False, include_context=False)
        }
        if "with" in faulty:
            return _broken(data)  # without its arguments it would be a different action
        rest = {key: value for key, value in rest.items() if key not in faulty}
        try:
            step = kind.model_validate(rest)
        except ValidationError:
            return _broken(data)
    if getattr(step, "watch", None):
        kept = zip(step.watch, thens, strict=True)  # type: ignore[attr-defined]
        inner["watch"] = [watch.model_copy(update=then) for watch, then in kept]
    return step.model_copy(update=inner) if inner else step


def _watches(
    items: list[Any], source: Source, place: Place, problems: list[Problem]
) -> tuple[list[Any], list[dict[str, Any]]]:
    """Watches with stand-ins for what happens then, and what that is, read step by step."""
    rest: list[Any] = []
    thens: list[dict[str, Any]] = []
    for index, item in enumerate(items):
        then, at = item.get("then") if isinstance(item, dict) else None, (*place, index, "then")
        if isinstance(then, list) and then:
            thens.append({"then": _steps(then, source, at, problems)})
        elif isinstance(then, dict):
            thens.append({"then": _step(then, source, at, problems)})
        else:
            thens.append({})
        rest.append({**item, "then": STAND_IN} if thens[-1] else item)
    return rest, thens


def _alternatives(
    items: list[Any], source: Source, place: Place, problems: list[Problem]
) -> list[Any]:
    return [
        _steps(item, source, (*place, index), problems)
        if isinstance(item, list) and item
        else _step(item, source, (*place, index), problems)
        for index, item in enumerate(items)
    ]


def _broken(data: dict[str, Any]) -> Broken:
    name = data.get("id")
    return Broken.model_construct(id=name if isinstance(name, str) else None)
