"""Twins of devices whose lab entry says their actions: `driver: sim_scpi` plays what `scpi` speaks to.

The config is the same. What is set is remembered and read back, a count goes up by one with every
`once` action, and the rest of what is returned is a value that the contract allows.
"""

import functools
from dataclasses import replace
from importlib import import_module
from typing import Any, ClassVar

from pydantic import Field, create_model

from ...schemas.contract import Action
from ...schemas.good_calls import duration_s, plain
from ...schemas.messages import FileContent
from ..bridges.bridge import Bridge, read_config
from ..bridges.config import LAST_ONCE, UNTIL, BridgeConfig, of_action
from ..driver import ActionCanceled, GoalContext, Place
from .twins.twin import SHARED, Twin

Values = dict[str, Any]
Key = tuple[str, str]
"""Of a value that is remembered: where it is, and its kind; `t` may be a time here and an array there."""


class SaidTwin(Twin):
    """Keeps whichever contract its lab says; what must not happen twice is recorded in `truth`."""

    any_contract: ClassVar[bool] = True
    config_model: ClassVar[type[BridgeConfig]]

    def __init__(self, place: Place) -> None:
        read: Any = read_config(self.config_model, place.config)
        self._said: dict[str, Any] = read.said()
        self._status: list[str] = read.status
        contract = place.contract or read.contract(f"{place.device.lower()}@1")
        shared = {key: place.config[key] for key in SHARED if key in place.config}
        super().__init__(replace(place, config=shared, contract=contract))
        self.actions = contract.actions
        self.now: dict[Key, Any] = {}
        for name, action in self.actions.items():
            for field, schema in action.returns.get("properties", {}).items():
                self.now.setdefault(self._key(name, field), plain(field, schema))

    def method(self, action: str) -> Any:
        """An action may be called as something of the driver's own is: `open`, `status`."""
        return functools.partial(self._do, action)

    def _key(self, action: str, field: str, given: Values | None = None) -> Key:
        """A value has the name of the property that is read or set, where there is one."""
        said = self._said.get(action)
        path = str(getattr(said, "get", None) or getattr(said, "set", None) or field)
        for name, one in (given or {}).items():
            path = path.replace(f"{{{name}}}", str(one))
        schemas = {**self.actions[action].param_schemas(), **self._fields(action)}
        return path, _kind(schemas.get(field, {}))

    async def status(self) -> Values:
        fields = ((n, f) for n in self._status for f in self._fields(n))
        return {field: self.now[self._key(name, field)] for name, field in fields}

    def _fields(self, name: str) -> Values:
        return self.actions[name].returns.get("properties", {})

    async def _do(self, name: str, goal: GoalContext, **values: Any) -> Values:
        action = self.actions[name]
        with self.failing(name, goal):
            if await self.clock.sleep_unless(goal.cancelled, duration_s(action)):
                raise ActionCanceled("stopped")
            if action.effect == "once":
                self.truth.append(name, goal=goal.id)
                self._count(name)
            given = {n: v for n, v in values.items() if v is not None}
            inside = getattr(self._said.get(name), "in_path", ())
            told = {n: v for n, v in given.items() if n not in inside}
            self.now |= {self._key(name, field, given): value for field, value in told.items()}
            self.now |= self._waited_for(name, given)
        unwanted = {path for path in action.path_params()[1] if values.get(path) is None}
        fields = [field for field in self._fields(name) if field not in unwanted]
        return {field: self._answer(name, action, field, goal, values) for field in fields}

    def _count(self, name: str) -> None:
        counted = getattr(self._said.get(name), "count", None)
        if counted is None:
            return
        for key in (self._key(counted, field) for field in self._fields(counted)):
            if isinstance(self.now[key], int):
                self.now[key] += 1

    def _waited_for(self, name: str, given: Values) -> dict[Key, Any]:
        known = {field: self.now[self._key(name, field)] for field in self._fields(name)} | given
        until: Values = getattr(self._said.get(name), "until", None) or {}
        wanted = {
            field: of_action(value, known) for field, value in until.items() if field not in UNTIL
        }
        return {self._key(until["do"], field): value for field, value in wanted.items()}

    def _answer(
        self, name: str, action: Action, field: str, goal: GoalContext, values: Values
    ) -> Any:
        if field == "goal_id" and name in {LAST_ONCE, *(a.probe for a in self.actions.values())}:
            return (self.truth.entry(len(self.truth)) or {"goal": ""})["goal"]
        if field in action.path_params()[1]:
            empty = FileContent.of(str(values[field]), b"")
            goal.files[field] = empty
            return values[field]
        key = self._key(name, field, values)
        return self.now.get(key, self.now[self._key(name, field)])


def _kind(schema: Values) -> str:
    kinds = schema.get("type", "")
    kinds = kinds if isinstance(kinds, list) else [kinds]
    return next((one.replace("integer", "number") for one in kinds if one != "null"), "")


@functools.cache
def __getattr__(name: str) -> type[SaidTwin]:
    """`SimScpi` is the twin of `Scpi` in `bridges/scpi.py`."""
    if not name.startswith("Sim"):
        raise AttributeError(name)
    bridge = name.removeprefix("Sim")
    return twin_of(getattr(import_module(f"..bridges.{bridge.lower()}", __package__), bridge))


def twin_of(real: type[Bridge]) -> type[SaidTwin]:
    """The twin of a bridge, of your own, too: it takes the same config, and what every twin takes."""
    name = f"Sim{real.__name__}"
    model = create_model(
        f"{name}Config", __base__=real.config_model, clock=(Any, "real"), seed=(int, 1),
        drawn_faults=(dict[str, Any], Field({}, alias="faults")),
    )  # fmt: skip
    return type(name, (SaidTwin,), {"config_model": model, "__module__": real.__module__})
