"""Machines of PyLabRobot: `call` is a method of the machine, `get` and `set` attributes.

A parameter with `format: resource` names what lies on the deck: `plate`, `plate.A1`, `tips.A1:H1`. What the
deck holds (tips, volumes) is kept beside the ledger after every action, and known again after a crash.
"""

import inspect
import json
from collections.abc import Awaitable
from pathlib import Path
from typing import Any, ClassVar

from pydantic import Field

from ...schemas.contract import Action
from ...system.files import write_whole
from ..driver import ActionFailed
from .bridge import Values
from .library import FAILED, Library, LibraryConfig, Refused, instrument_class, last_of

PACKAGE, STATE = "pylabrobot", "deck.json"
RESOURCE = "resource"


class PylabrobotConfig(LibraryConfig):
    """The config of `driver: pylabrobot`; a function that returns a whole machine needs no `backend`."""

    own_errors: ClassVar = {**LibraryConfig.own_errors, **FAILED}

    backend: str | None = None
    backend_options: dict[str, Any] = Field(default_factory=dict)
    deck: str | None = None


class Pylabrobot(Library):
    """Implements whichever contract its lab says or names."""

    config_model: ClassVar = PylabrobotConfig
    extra: ClassVar[str | None] = "pylabrobot"
    library: ClassVar = "PyLabRobot"
    on_loop = True

    async def connect(self) -> Any:
        config = self.config
        found = instrument_class(self.library, PACKAGE, config.instrument)
        options = coordinates(found, config.options)
        if config.backend is not None:
            backend = instrument_class(self.library, PACKAGE, config.backend)
            options["backend"] = backend(**config.backend_options)
        if config.deck is not None:
            deck = instrument_class(self.library, PACKAGE, "resources.Deck")
            options["deck"] = deck.load_from_json_file(config.deck)
        made = found(**options)
        await made.setup()
        if self._state.exists() and hasattr(made, "load_all_state"):
            made.load_all_state(json.loads(self._state.read_bytes(), object_hook=whole_keys))
        self.versions = {"instrument": type(made.backend).__name__}
        return made

    @property
    def _state(self) -> Path:
        return self.place.folder / STATE

    def disconnect(self, instrument: Any) -> Any:
        return instrument.stop()

    async def _do_it(self, said: Any, action: Action, values: Values) -> Any:
        try:
            found = super()._do_it(said, action, values)
            return await found if isinstance(found, Awaitable) else found
        finally:
            if action.effect != "pure" and hasattr(self._instrument, "serialize_all_state"):
                write_whole(
                    self._state, json.dumps(self._instrument.serialize_all_state()).encode()
                )

    def meaning(self, path: str, fault: Exception, action: Action) -> Exception:
        if isinstance(fault, (OSError, Refused)):
            return fault
        return ActionFailed("Failed", f"{type(fault).__name__}: {fault}")

    def call(self, path: str, values: Values, action: Action) -> Any:
        schemas = action.param_schemas()
        given = {n: self._resources(v, schemas.get(n, {})) for n, v in values.items()}
        first, _, rest = path.partition(".")
        if rest and not hasattr(self._instrument, first):  # of something on the deck: `tips.fill`
            return last_of(self._on_deck(first), rest)(**given)
        return last_of(self._instrument, path)(**given)

    def _resources(self, value: Any, schema: dict[str, Any]) -> Any:
        if schema.get("format") == RESOURCE and isinstance(value, str):
            return self._on_deck(value)
        if schema.get("items", {}).get("format") == RESOURCE:
            found = [self._on_deck(one) for one in value]
            return [one for part in found for one in (part if isinstance(part, list) else [part])]
        return value

    def _on_deck(self, name: str) -> Any:
        """`plate`, its well `plate.A1`, or several, `plate.A1:C1`; raises Refused."""
        owner, _, place = name.partition(".")
        try:
            there = getattr(self._instrument, "deck", self._instrument).get_resource(owner)
            items = there[place] if place else there
        except Exception as fault:  # its classes have no common base
            raise Refused(f"there is no {name} on the deck ({fault})") from fault
        return items[0] if place and ":" not in place else items


def whole_keys(read: dict[str, Any]) -> dict[Any, Any]:
    """The numbers of channels, which JSON has as texts."""
    return {int(key) if key.isdigit() else key: value for key, value in read.items()}


def coordinates(found: Any, options: dict[str, Any]) -> dict[str, Any]:
    """The options, with [x, y, z] as the library's Coordinate where it wants one."""
    made = dict(options)
    for name, param in inspect.signature(found).parameters.items():
        if isinstance(made.get(name), list) and "Coordinate" in str(param.annotation):
            coordinate = instrument_class("PyLabRobot", PACKAGE, "resources.Coordinate")
            made[name] = coordinate(*made[name])
    return made
