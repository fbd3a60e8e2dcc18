"""A lab entry as text, from what a source knows of an instrument: an action a line."""

import json
from collections.abc import Iterator
from typing import Any

from .sources import Described

SPOKEN = {"on", "off", "yes", "no", "y", "n", "true", "false", "null"}
"""Words that YAML may read as something else."""
UNSURE = "# Below, `effect` is a guess: say `idempotent` or `pure` where twice does no harm."


def entry_text(name: str, known: Described) -> str:
    """The lines of a lab for this device."""
    return "".join(f"  {line}\n" for line in _lines(name, known))


def _lines(name: str, known: Described) -> Iterator[str]:
    yield f"{name}:"
    yield f"  driver: {known.driver}"
    yield "  config:"
    for key, value in known.config.items():
        note = f"     # {known.notes[key]}" if key in known.notes else ""
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


def flow(data: Any) -> str:
    """Data as YAML on one line."""
    if isinstance(data, dict):
        return "{" + ", ".join(f"{_key(key)}: {flow(value)}" for key, value in data.items()) + "}"
    if isinstance(data, (list, tuple)):
        return "[" + ", ".join(flow(one) for one in data) + "]"
    return _key(data) if isinstance(data, str) else json.dumps(data)


def _key(text: Any) -> str:
    plain = str(text).replace(".", "").replace("-", "_")
    if not plain.isidentifier() or str(text)[0] in "-." or plain.lower() in SPOKEN:
        return json.dumps(str(text))
    return str(text)
