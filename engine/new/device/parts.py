"""Pieces of Python derived from a contract: signatures, and what a twin remembers."""

from typing import Any

from ....schemas.contract import Action, Contract
from ....schemas.good_calls import plain


def signature(action: Action) -> str:
    """The parameters of an action's method."""
    required = action.required()
    words = [name if name in required else f"{name}=None" for name in action.param_schemas()]
    return ", ".join(["self", "goal", *(["*", *words] if words else [])])


def memory(contract: Contract) -> dict[str, Any]:
    """What a twin remembers: every status field, parameter and result."""
    known: dict[str, Any] = {}
    for action in contract.actions.values():
        fields = {**action.returns.get("properties", {}), **action.param_schemas()}
        fields = {n: s for n, s in fields.items() if s.get("format") != "path" and n != "goal_id"}
        known |= {n: plain(n, s) for n, s in fields.items()}
    fields = contract.status.get("properties", {})
    return known | {name: plain(name, schema) for name, schema in fields.items()}
