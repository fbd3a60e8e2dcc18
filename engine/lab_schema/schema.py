"""Put together the JSON Schema of protocols for one lab."""

import json
from typing import Any

from ...schemas.protocol import Protocol
from ..lab.lab import LoadedLab
from .devices import kept_contracts
from .models import closed
from .params import param_shape
from .roles import role_rules, role_shapes
from .steps import step_shapes

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def lab_schema(lab: LoadedLab) -> dict[str, Any]:
    """The JSON Schema (2020-12) of a protocol that runs in this lab."""
    frame = closed(Protocol)
    return {
        "$schema": DIALECT,
        "title": f"labrun protocol for the lab {lab.lab.name}",
        **frame,
        "allOf": role_rules(lab),
        "$defs": {"param": param_shape(), **step_shapes(_errors(lab)), **role_shapes(lab)},
    }


def schema_text(lab: LoadedLab) -> str:
    """The schema as file text; the same lab gives the same text."""
    return json.dumps(lab_schema(lab), indent=1, ensure_ascii=False) + "\n"


def _errors(lab: LoadedLab) -> dict[str, str]:
    """Error name -> what it means, of every action in the lab."""
    found: dict[str, str] = {}
    for contract in kept_contracts(lab).values():
        for name, action in contract.actions.items():
            for error, said in action.errors.items():
                found.setdefault(error, said.summary or f"{contract.type} {name}")
    return found
