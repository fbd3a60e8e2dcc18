"""A lab entry and a contract test as text, from what a source knows of an instrument."""

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from fnmatch import fnmatchcase
from typing import Any

from ...language.suggest import closest, listed
from ..protocol import CannotMake
from .render import class_name
from .sources import Described

SPOKEN = {"on", "off", "yes", "no", "y", "n", "true", "false", "null"}
"""Words that YAML may read as something else."""
UNSURE = "# Below, `effect` is a guess: say `idempotent` or `pure` where twice does no harm."


TEST = '''"""{Words}: its twin keeps the contract that {lab} says."""

from pathlib import Path

from labrun.drivers.contract_tests import Case, KeepsContract


class TestSim{Class}(KeepsContract):
    case = Case.of_lab(Path(__file__).parent / "{lab}", "{name}")
'''


def test_text(name: str, lab: str) -> str:
    """The contract test of a device whose lab entry says its actions."""
    words = name.replace("_", " ").capitalize()
    return TEST.format(name=name, lab=lab, Words=words, Class=class_name(name))


def only(known: Described, patterns: str) -> Described:
    """With the actions whose names fit one of these patterns, `read_*,move`, and what ends them or makes
    the device harmless; raises CannotMake.
    """
    wanted = [one.strip() for one in patterns.split(",")]
    kept = {n: s for n, s in known.actions.items() if any(fnmatchcase(n, one) for one in wanted)}
    lost = [one for one in wanted if not any(fnmatchcase(n, one) for n in known.actions)]
    if lost or not kept:
        near = [n for one in lost for n in known.actions if fnmatchcase(n.lower(), one.lower())]
        near = near or [n for one in lost if (n := closest(one.strip("*"), known.actions))]
        guess = f"; did you mean {listed(dict.fromkeys(near), last='or')}?" if near else ""
        raise CannotMake(
            f"no action fits {', '.join(lost)}{guess}; there is {listed(known.actions)}"
        )
    ends = {known.config.get("abort"), *known.config.get("safe_state", [])}
    kept = {n: said for n, said in known.actions.items() if n in kept or n in ends}
    return replace(known, actions=kept)


def entry_text(name: str, known: Described) -> str:
    """The lines of a lab for this device."""
    return "".join(f"  {line}\n" for line in _lines(name, known))


def _lines(name: str, known: Described) -> Iterator[str]:
    yield f"{name}:"
    yield f"  driver: {known.driver}"
    yield "  config:"
    for key, value in known.config.items():
        note = f"     # {known.notes[key]}" if key in known.notes else ""
        if isinstance(value, dict) and any(isinstance(one, dict) for one in value.values()):
            yield f"    {key}:{note}"
            yield from (f"      {_key(name)}: {flow(one)}" for name, one in value.items())
        else:
            yield f"    {key}: {flow(value)}{note}"
    yield "    actions:"
    for action, said in known.actions.items():
        if action not in known.unsure:
            yield f"      {action}: {flow(said)}"
    if known.unsure:
        yield f"      {UNSURE}"
    for action, said in known.actions.items():
        if action in known.unsure:
            yield f"      {action}: {flow(said)}"


def _key(text: Any) -> str:
    plain = str(text).replace(".", "").replace("-", "_")
    if not plain.isidentifier() or str(text)[0] in "-." or plain.lower() in SPOKEN:
        return json.dumps(str(text))
    return str(text)


def flow(data: Any, text: Callable[[str], str] = _key) -> str:
    """Data as YAML on one line; `text` writes a text, with quotation marks where it needs them."""
    if isinstance(data, dict):
        return "{" + ", ".join(f"{text(k)}: {flow(one, text)}" for k, one in data.items()) + "}"
    if isinstance(data, (list, tuple)):
        return "[" + ", ".join(flow(one, text) for one in data) + "]"
    return text(data) if isinstance(data, str) else json.dumps(data)
