"""A manual action as a protocol step: what Record and Add to protocol insert into the text."""

import json
import re
from typing import Any

PLAIN = re.compile(r"[A-Za-z][A-Za-z0-9_./-]*")
LOOKS_LIKE_MORE = {"true", "false", "null", "yes", "no", "on", "off", "y", "n"}


def step_text(device: str, action: str, params: dict[str, Any]) -> str:
    """`{do: gantry.move_to, with: {x: 10.5}}`; numbers are in the contract's units."""
    given = ", ".join(f"{name}: {_value(value)}" for name, value in params.items())
    with_ = f", with: {{{given}}}" if given else ""
    return f"{{do: {device}.{action}{with_}}}"


def _value(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.10g}"
    if isinstance(value, str) and PLAIN.fullmatch(value) and value.lower() not in LOOKS_LIKE_MORE:
        return value
    return json.dumps(value, ensure_ascii=False)  # JSON is YAML
