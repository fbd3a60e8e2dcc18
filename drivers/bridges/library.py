"""What bridges to the field's Python libraries share: `get`, `set` and `call` of one instrument.

A library that blocks has a thread of its own, an asynchronous one runs on the server's loop.
`labrun new device NAME --from ...` writes the actions of a class of instruments.
"""

import asyncio
import contextlib
import inspect
import logging
import re
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from importlib.util import find_spec
from types import BuiltinFunctionType, FunctionType, MethodType
from typing import Any, ClassVar

from pydantic import Field, model_validator

from ...schemas.contract import Action, Effect, Name
from ...system.extras import EXTRAS, absent, not_installed
from ..driver import ActionFailed, GoalContext
from .answers import NUMBER_ERRORS, BadAnswer
from .bridge import ABORTED_S, Bridge, Values
from .config import ActionConfig, BridgeConfig, chosen
from .data import found_at, plain
from .lines import NoAnswer
from .resource import Served
from .template import fill

LOG = logging.getLogger("labrun")
FAILED = {"Failed": ("unknown", "The library or the instrument says that it failed")}
"""For libraries whose exceptions are about the action, not about the connection."""


IN_PATH = re.compile(r"\{(\w+)\}")
METHODS = (FunctionType, MethodType, BuiltinFunctionType, classmethod, staticmethod)


class Refused(ValueError):
    """The library would not take a value, and nothing was sent."""


class LibraryAction(ActionConfig):
    """One of `get: voltage`, `set: ch_{channel}.range` (its one other parameter) and `call: reset`."""

    get: str | None = None
    set: str | None = None
    call: str | None = None

    @model_validator(mode="after")
    def _one(self) -> "LibraryAction":
        if len(chosen(self, ("get", "set", "call"))) != 1:
            raise ValueError("it needs one of `get: property`, `set: property` and `call: method`")
        if self.set is not None and len(self.params.keys() - self.in_path) > 1:
            raise ValueError("a property is set to one parameter, beside those in its path")
        return self

    @property
    def path(self) -> str:
        """Of the property or method, with parameters in it: `ch_{channel}.voltage`."""
        return str(self.get or self.set or self.call)

    @property
    def in_path(self) -> frozenset[str]:
        """The parameters that the path takes."""
        return frozenset(IN_PATH.findall(self.path))

    def used(self) -> Iterator[tuple[str, str]]:
        if self.in_path:
            yield ("get" if self.get else "set" if self.set else "call"), self.path

    def guessed_effect(self) -> Effect:
        return "pure" if self.get is not None else "once"


class LibraryActions(BridgeConfig):
    """What the config of every driver has that calls a library."""

    own_keys = ("at",)
    own_errors = NUMBER_ERRORS  # type: ignore[assignment]

    actions: dict[Name, LibraryAction] = Field(min_length=1)


class LibraryConfig(LibraryActions):
    """For a library that has a class for each instrument."""

    instrument: str = Field(pattern=r"^[A-Za-z]\w*(\.\w+)+$")
    options: dict[str, Any] = Field(default_factory=dict)


class ServerConfig(Served, LibraryActions):
    """For a server that says itself what it has, at its `url`."""

    own_errors = {**NUMBER_ERRORS, **FAILED}  # type: ignore[assignment] # noqa: RUF012

    @property
    def instrument(self) -> str:
        """What a failure to connect names."""
        return self.url


def instrument_class(library: str, package: str, name: str) -> Any:
    """`keithley.Keithley2000` of a library's package, or what a module has by its whole name.

    Raises OSError with the way on.
    """
    module, _, wanted = name.rpartition(".")
    inside, first = f"{package}.{module}", package.partition(".")[0]
    try:
        there = import_module(inside if _is_there(inside) else module)
    except ImportError as fault:
        if not _is_there(first) and fault.name == module.partition(".")[0]:
            fault = ModuleNotFoundError(name=first)  # a module of the library that is not installed
        why = not_installed(fault) or f"{library} has no instruments of {module!r}: {fault}"
        raise OSError(why) from fault
    found = getattr(there, wanted, None)
    if found is None:
        known = sorted(n for n, one in vars(there).items() if isinstance(one, type))
        raise OSError(f"{library}'s {module} has no {wanted}; it has {', '.join(known) or 'none'}")
    return found


def _is_there(module: str) -> bool:
    try:
        return find_spec(module) is not None
    except ModuleNotFoundError:
        return False


class Library(Bridge):
    """Implements whichever contract its lab says or names."""

    library: ClassVar[str]
    """As people write it."""
    on_loop: bool = False
    """True if it is asynchronous: it then runs on the server's loop."""
    silent_hint: ClassVar[str] = ""
    """What may be wrong where nothing comes."""
    stops_beside: bool = False
    """True if another thread may call its `abort` while the first is still waiting."""
    _instrument: Any = None
    _thread: ThreadPoolExecutor | None = None

    @classmethod
    def lacks(cls, config: dict[str, Any]) -> str | None:
        """Nothing that can be known here where the instrument's class is in a module of its own."""
        module = str(config.get("instrument", "")).partition(".")[0]
        known = EXTRAS[cls.extra] if cls.extra is not None else ()
        if not module or not known:
            return super().lacks(config)
        library = module if module in known else known[0]
        return None if _is_there(module) else absent(library, cls.extra)

    def connect(self) -> Any:
        """The instrument, opened; raises what the library raises. May be awaitable."""
        raise NotImplementedError

    def disconnect(self, instrument: Any) -> Any:
        """Close it; may be awaitable."""

    def get(self, path: str) -> Any:
        """The value of a property, `ch_1.voltage` for a channel's."""
        return last_of(self._instrument, path)

    def set(self, path: str, value: Any) -> Any:
        """Set a property; raises Refused if the library does not take the value."""
        inside, _, name = path.rpartition(".")
        owner = last_of(self._instrument, inside)
        there = inspect.getattr_static(owner, name, None)  # a property is not asked for its value
        if isinstance(there, METHODS):
            raise Refused(f"{name} is a method of {type(owner).__name__}: say `call: {path}`")
        if there is None and not hasattr(owner, name):
            raise Refused(f"{type(owner).__name__} has no {name}, so that nothing would be set")
        setattr(owner, name, value)

    def call(self, path: str, values: Values, action: Action) -> Any:
        """Call a method; what it returns is read as `returns`."""
        return last_of(self._instrument, path)(**values)

    async def ready(self, timeout_s: float) -> None:
        if self._instrument is not None:
            return
        if not self.on_loop:
            self._thread = ThreadPoolExecutor(1, f"{self.library} {self.place.device}")
        try:
            self._instrument = await self._run(self.connect)
        except Exception as fault:  # whatever the library raises
            resource = getattr(self.config, "resource", None)
            where = f" at {resource}" if resource else ""
            raise OSError(f"{self.config.instrument}{where}: {fault}") from fault

    async def _run(self, work: Callable[..., Any], *given: Any, beside: bool = False) -> Any:
        if self.on_loop:
            found = work(*given)
        else:
            thread = None if beside else self._thread
            found = await asyncio.get_running_loop().run_in_executor(thread, work, *given)
        return await found if inspect.isawaitable(found) else found

    async def drop(self) -> None:
        instrument, self._instrument = self._instrument, None
        thread, self._thread = self._thread, None
        if instrument is not None and thread is None:
            with contextlib.suppress(Exception):  # it is given up, whatever the library raises
                async with asyncio.timeout(ABORTED_S):
                    await self._run(self.disconnect, instrument)
        if thread is not None:
            if instrument is not None:  # it is closed once what still blocks has returned
                thread.submit(self.disconnect, instrument)
            thread.shutdown(wait=False)

    async def perform(
        self, said: LibraryAction, action: Action, values: Values, goal: GoalContext
    ) -> Values:
        if self._instrument is None:
            raise OSError("the connection was closed")
        limit_s = self.timeout_s(said)
        beside = goal.id == "abort" and self.stops_beside
        try:
            async with asyncio.timeout(limit_s):
                found = await self._run(self._do_it, said, action, values, beside=beside)
        except TimeoutError as fault:
            raise NoAnswer(f"{self.library} has not returned within {limit_s:g} s") from fault
        except Exception as fault:  # VISA's, the adapters' and the instruments' own
            raise self._told(said.path, self.meaning(said.path, fault, action)) from fault
        return returned(found, self.returns(said, action), self.library)

    def meaning(self, path: str, fault: Exception, action: Action) -> Exception:
        """What the library raised, as Refused, ActionFailed or OSError where it means that."""
        return fault

    def _told(self, path: str, fault: Exception) -> Exception:
        if isinstance(fault, Refused):
            return ActionFailed("Rejected", f"{path}: {fault}", "no")
        if isinstance(fault, ActionFailed):
            return fault
        if isinstance(fault, (ValueError, LookupError)):
            return BadAnswer(f"{self.library} cannot read the answer: {fault}")
        if "VI_ERROR_TMO" in str(fault) or "imeout" in type(fault).__name__:
            return NoAnswer(f"the instrument was silent{self.silent_hint} ({fault})")
        LOG.error("%s of %s failed", path, self.place.device, exc_info=fault)
        return OSError(f"{type(fault).__name__}: {fault}")

    def _do_it(self, said: LibraryAction, action: Action, values: Values) -> Any:
        path = said.path
        if said.in_path:
            path = fill(path, values, action.param_schemas(), "")
            values = {name: one for name, one in values.items() if name not in said.in_path}
        if said.get is not None:
            return self.get(path)
        if said.set is not None:
            return self.set(path, next(iter(values.values())))
        return self.call(path, values, action)


def last_of(there: Any, path: str) -> Any:
    """What a dotted path leads to: `ch_1.voltage`."""
    for name in path.split(".") if path else ():
        there = there[int(name)] if name.isdigit() else getattr(there, name)
    return there


def returned(found: Any, returns: dict[str, Any], library: str) -> Values:
    """What a library returned, as a contract's `returns`: by place, by name, in order, or the only one."""
    if any("at" in schema for schema in returns.values()):
        return {name: found_at(found, name, s.get("at", ""), s) for name, s in returns.items()}
    if isinstance(found, tuple | list) and len(found) == len(returns) > 1:
        found = dict(zip(returns, found, strict=True))
    whole = found if isinstance(found, dict) else dict.fromkeys(list(returns)[:1], found)
    if lacking := [name for name in returns if name not in whole]:
        raise BadAnswer(f"{library} returned {found!r}, which has no {lacking[0]}")
    return {name: plain(whole[name], schema) for name, schema in returns.items()}
