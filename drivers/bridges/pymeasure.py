"""Instruments that PyMeasure knows: `get` and `set` are its properties, `call` its methods.

The library blocks, so it has a thread of its own. `labrun new device NAME --from pymeasure:...`
writes the actions of a class of instruments.
"""

import asyncio
import math
from concurrent.futures import ThreadPoolExecutor
from enum import Enum
from importlib import import_module
from typing import Any, ClassVar

from pydantic import Field, model_validator

from ...schemas.contract import Action, Effect, Name
from ...system.extras import not_installed
from ..driver import ActionFailed, GoalContext
from .answers import INFINITE, BadAnswer, none_for, value
from .bridge import Bridge, Values
from .by_action import ByAction
from .config import ActionConfig
from .line_bridge import NUMBER_ERRORS
from .lines import NoAnswer

PACKAGE = "pymeasure.instruments"


class PymeasureAction(ActionConfig):
    """One of `get: voltage`, `set: voltage_range` (its one parameter) and `call: reset`."""

    get: str | None = None
    set: str | None = None
    call: str | None = None

    @model_validator(mode="after")
    def _one(self) -> "PymeasureAction":
        if len([one for one in (self.get, self.set, self.call) if one is not None]) != 1:
            raise ValueError("it needs one of `get: property`, `set: property` and `call: method`")
        if self.set is not None and len(self.params) > 1:
            raise ValueError("a property is set to one parameter")
        return self

    def guessed_effect(self) -> Effect:
        return "pure" if self.get is not None else "once"


class PymeasureConfig(ByAction):
    """The config of `driver: pymeasure`."""

    own_errors = NUMBER_ERRORS  # type: ignore[assignment]

    instrument: str = Field(pattern=r"^[a-z]\w*(\.\w+)+$")
    resource: str
    visa_library: str = "@py"
    options: dict[str, Any] = Field(default_factory=dict)
    actions: dict[Name, PymeasureAction] = Field(min_length=1)
    status: list[str] = Field(default_factory=list)


def instrument_class(name: str) -> Any:
    """`keithley.Keithley2000` as PyMeasure's class; raises OSError with the way on."""
    module, _, wanted = name.rpartition(".")
    try:
        import_module(PACKAGE)
    except ImportError as fault:
        raise OSError(not_installed(fault) or str(fault)) from fault
    try:
        there = import_module(f"{PACKAGE}.{module}")
    except ImportError as fault:
        raise OSError(f"PyMeasure has no instruments of {module!r}: {fault}") from fault
    found = getattr(there, wanted, None)
    if not isinstance(found, type):
        known = sorted(n for n, one in vars(there).items() if isinstance(one, type))
        raise OSError(f"PyMeasure's {module} has no {wanted}; it has {', '.join(known) or 'none'}")
    return found


class Pymeasure(Bridge):
    """Implements whichever contract its lab says or names."""

    config_model: ClassVar = PymeasureConfig
    _instrument: Any = None
    _thread: ThreadPoolExecutor | None = None

    async def ready(self, timeout_s: float) -> None:
        if self._instrument is None:
            self._thread = ThreadPoolExecutor(1, f"pymeasure {self.place.device}")
            try:
                self._instrument = await self._called(self._open)
            except Exception as fault:
                await self.drop()
                raise OSError(
                    f"{self.config.instrument} at {self.config.resource}: {fault}"
                ) from fault

    def _open(self) -> Any:
        found = instrument_class(self.config.instrument)
        made = found(
            self.config.resource, visa_library=self.config.visa_library, **self.config.options
        )
        self.versions = {"instrument": str(made.name)}
        return made

    async def _called(self, work: Any, *given: Any) -> Any:
        return await asyncio.get_running_loop().run_in_executor(self._thread, work, *given)

    async def drop(self) -> None:
        instrument, self._instrument = self._instrument, None
        thread, self._thread = self._thread, None
        if thread is None:
            return
        if instrument is not None:  # it is closed once what still blocks has returned
            thread.submit(instrument.adapter.close)
        thread.shutdown(wait=False)

    async def perform(
        self, said: PymeasureAction, action: Action, values: Values, goal: GoalContext
    ) -> Values:
        if self._instrument is None:
            raise OSError("the connection was closed")
        limit_s = self.timeout_s(said)
        try:
            async with asyncio.timeout(limit_s):
                found = await self._called(self._do_it, said, values)
        except TimeoutError as fault:
            raise NoAnswer(f"PyMeasure has not returned within {limit_s:g} s") from fault
        except ValueError as fault:
            if said.set is not None:  # its validator looks before anything is sent
                raise ActionFailed("Rejected", f"{said.set}: {fault}", "no") from fault
            raise BadAnswer(f"PyMeasure cannot read the answer: {fault}") from fault
        except Exception as fault:  # VISA's, the adapters' and the instruments' own
            if "VI_ERROR_TMO" in str(fault) or "imeout" in type(fault).__name__:
                raise NoAnswer(f"the instrument was silent ({fault})") from fault
            raise OSError(f"{type(fault).__name__}: {fault}") from fault
        returns = action.returns.get("properties", {})
        whole = found if isinstance(found, dict) else dict.fromkeys(list(returns)[:1], found)
        if lacking := [name for name in returns if name not in whole]:
            raise BadAnswer(f"PyMeasure returned {found!r}, which has no {lacking[0]}")
        return {name: plain(whole[name], schema) for name, schema in returns.items()}

    def _do_it(self, said: PymeasureAction, values: Values) -> Any:
        if said.get is not None:
            return _last_of(self._instrument, said.get)
        if said.set is not None:
            owner, _, name = said.set.rpartition(".")
            target = _last_of(self._instrument, owner) if owner else self._instrument
            return setattr(target, name, next(iter(values.values())))
        return _last_of(self._instrument, str(said.call))(**values)


def _last_of(there: Any, path: str) -> Any:
    for name in path.split("."):
        there = getattr(there, name)
    return there


def plain(found: Any, schema: dict[str, Any]) -> Any:
    """A library's value as JSON has it; raises BadAnswer or NoNumber."""
    if hasattr(found, "tolist"):  # numpy's, arrays and numbers
        found = found.tolist()
    if hasattr(found, "magnitude"):  # pint's
        from ...schemas.quantity import magnitude_in

        found = magnitude_in(found, schema.get("unit", ""))
    if isinstance(found, Enum):
        found = found.name
    if isinstance(found, (list, tuple)):
        return [plain(one, schema.get("items", {})) for one in found]
    if isinstance(found, float) and math.isnan(found):
        return none_for("NotANumber", "it has no number", schema)
    if isinstance(found, float) and abs(found) >= INFINITE * (1 - 1e-6):
        return none_for("Overload", f"{found:g} is beyond its range", schema)
    kinds = schema.get("type", "number")
    if isinstance(found, str):  # PyMeasure hands on the text of what it cannot read as a number
        return value(found, schema)
    if found is not None and not isinstance(found, (bool, int, float, str)):
        raise BadAnswer(f"it returned {found!r}, where {kinds} is expected")
    return bool(found) if kinds == "boolean" and isinstance(found, (int, float)) else found
