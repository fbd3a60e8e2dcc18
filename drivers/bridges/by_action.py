"""What `modbus` and `http` share: an abort is one of the actions, and values are put into data."""

from collections.abc import Iterator, Mapping
from typing import Any

from ...schemas.contract import Contract
from .config import WHOLE, BridgeConfig, ConfigFault
from .template import fill, written


class ByAction(BridgeConfig):
    """A config whose `abort` names an action."""

    def faults(self, contract: Contract, *, apart: bool) -> Iterator[ConfigFault]:
        yield from super().faults(contract, apart=apart)
        if self.abort is not None:
            yield from self._named(("abort",), self.abort)


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
