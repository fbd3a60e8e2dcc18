"""The actions of a machine as PyLabRobot describes it: its methods, their annotations and docstrings.

The backend that is written is the one that prints what it is told; a comment names the others.
"""

import inspect
import re
from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any, get_type_hints

from ....drivers.bridges.library import instrument_class
from ....drivers.bridges.pylabrobot import PACKAGE, RESOURCE
from ..protocol import CannotMake
from .metadata import Schema, of_annotation, of_parameter, parameters, unit_in
from .sources import LONG, Described

BY_NAME = {
    "temperature": "degC", "duration": "s", "time": "s", "timeout": "s", "vol": "uL",
    "vols": "uL", "wavelength": "nm", "angle": "deg", "flow_rate": "uL/s", "flow_rates": "uL/s",
    "height": "mm", "weight": "g", "temp": "degC", "speed": "", "tolerance": "degC",
}  # fmt: skip
"""What PyLabRobot measures in, where a docstring does not say it: the last word of a name -> unit."""
NAMED_RESOURCES = r"Resource|Plate|Well|Container|Tip(Spot|Rack)|Trash|Lid"
STOPS = ("stop_shaking", "halt", "deactivate", "deactivate_block", "deactivate_lid", "turn_off")
DECK = "deck.json"


def describe(source: str) -> Described:
    """The machine behind `pylabrobot:MODULE.CLASS`; raises CannotMake and OSError."""
    name = source.partition(":")[2]
    found = instrument_class("PyLabRobot", PACKAGE, name)
    machine = instrument_class("PyLabRobot", PACKAGE, "machines.Machine")
    resource = instrument_class("PyLabRobot", PACKAGE, "resources.Resource")
    if not (isinstance(found, type) and issubclass(found, machine)):
        raise CannotMake(f"{name} is not a class of machines of PyLabRobot")
    base = {*dir(machine), *dir(resource)}
    actions = dict(_actions(found, base))
    if not actions:
        raise CannotMake(f"{name} has no methods that could be actions")
    config: dict[str, Any] = {"instrument": name, "timeout": "10 s"}
    notes = {}
    if "backend" in inspect.signature(found).parameters:
        config["backend"], *others = _backends(found, name)
        prints = "prints what it is told; " if "Chatterbox" in config["backend"] else ""
        notes["backend"] = f"{prints}others: {', '.join(others) or 'none'}"
    options, lacking = _options(found)
    if lacking:
        raise CannotMake(
            f"{name} needs {', '.join(lacking)}: write a function that returns the machine, and "
            "name that as `instrument`"
        )
    if "deck" in inspect.signature(found).parameters:
        config["deck"] = DECK
        notes["deck"] = "what PyLabRobot's deck.save() wrote"
    if options:
        config["options"] = options
        notes["options"] = "in mm"
    if stops := [one for one in STOPS if one in actions]:
        config |= {"abort": stops[0], "safe_state": stops}
    return Described("pylabrobot", config, actions, notes)


def _actions(found: type, base: set[str]) -> Iterator[tuple[str, dict[str, Any]]]:
    for name in sorted(set(dir(found)) - base):
        method = inspect.getattr_static(found, name)
        plain = inspect.unwrap(method) if callable(method) else None
        if name.startswith("_") or not inspect.iscoroutinefunction(plain):
            continue
        words = inspect.getdoc(plain) or ""
        params = parameters(plain, _of(words))
        if params is None:
            continue
        effect = _effect(name)
        said = {"call": name, "effect": effect, **(LONG if effect == "once" else {})}
        returns = _returns(name, plain, words)
        yield name, {**said, **({"params": params} if params else {}), **returns}


def _effect(name: str) -> str:
    if name.startswith(("get_", "request_", "is_")):
        return "pure"
    return "idempotent" if name.startswith("set_") or name in STOPS else "once"


def _of(words: str) -> Callable[[inspect.Parameter], Schema | None]:
    """The schema of a parameter, with what the docstring's `Args` say of it."""

    def schema(param: inspect.Parameter) -> Schema | None:
        text = str(param.annotation)
        if re.search(rf"\b({NAMED_RESOURCES})\b", text):
            several = re.match(r"(typing\.)?(Optional\[)?(typing\.)?(Sequence|List|list)\b", text)
            one = {"type": "string", "format": RESOURCE}
            return {"type": "array", "items": one} if several else one
        found = of_parameter(param)
        said = re.search(rf"^\s*{param.name}:\s*(.+)", words, re.M)
        return None if found is None else with_unit(found, param.name, said[1] if said else "")

    return schema


def with_unit(schema: Schema, name: str, words: str) -> Schema:
    """A number with the unit that its documentation or its name says."""
    if schema.get("type") == "array":
        return {**schema, "items": with_unit(schema["items"], name, words)}
    if schema.get("type") not in ("number", "integer") or "enum" in schema:
        return schema
    known = next((u for n, u in BY_NAME.items() if re.search(rf"(^|_){n}$", name)), "")
    return {**schema, **(unit_in(words) or ({"unit": known} if known else {}))}


def _returns(name: str, method: Any, words: str) -> dict[str, Any]:
    try:
        annotation = get_type_hints(method).get("return")
    except Exception:  # a name that is there for type checkers only
        annotation = None
    schema = of_annotation(annotation)
    if schema is None:
        return {}
    field = re.sub(r"^(get|request|read|is)_", "", name)
    schema = {k: v for k, v in with_unit(schema, field, "").items() if k != "enum"}
    return {"returns": {field: schema}}


def _backends(found: Any, name: str) -> list[str]:
    """The backends for a machine by their short names, first the one that only prints."""
    room = name.rpartition(".")[0]
    wanted = get_type_hints(found.__init__).get("backend")
    seen: dict[str, Any] = {}
    for module in (room, f"{room}.backends", f"{room}.chatterbox"):
        try:
            there = vars(import_module(f"{PACKAGE}.{module}"))
        except ImportError:  # not every room has them
            continue
        for one in there.values():
            fits = isinstance(one, type) and isinstance(wanted, type) and issubclass(one, wanted)
            if fits and not inspect.isabstract(one) and one.__name__.endswith("Backend"):
                seen.setdefault(one.__name__, f"{module}.{one.__name__}")
    if not seen:
        raise CannotMake(f"PyLabRobot has no backend for {name} that could be named here")
    prints = f".{found.__name__}ChatterboxBackend"
    return sorted(seen.values(), key=lambda o: (not o.endswith(prints), "Chatterbox" not in o))


def _options(found: Any) -> tuple[dict[str, Any], list[str]]:
    """What the class needs beside backend and deck, and what nobody can guess of that."""
    options: dict[str, Any] = {}
    lacking: list[str] = []
    for name, param in list(inspect.signature(found.__init__).parameters.items())[1:]:
        if param.default is not param.empty or name in ("backend", "deck"):
            continue
        text = str(param.annotation)
        if name == "name":
            options[name] = "device"
        elif name.startswith("size_"):
            options[name] = 100
        elif "Coordinate" in text:
            options[name] = [0, 0, 0]
        elif re.search("list", text, re.I):
            options[name] = []
        elif param.kind not in (param.VAR_KEYWORD, param.VAR_POSITIONAL):
            lacking.append(name)
    return options, lacking
