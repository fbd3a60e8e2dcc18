"""An instrument that any Python class speaks to: `get` and `set` are its attributes, `call` its methods.

For a library that has no driver of its own here. The class is named wholly, and may as well be a
function in a file beside the lab that returns the instrument, connected and set up.
"""

import inspect
from importlib import import_module
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from typing import Any, ClassVar

from pydantic import Field

from ...schemas.contract import Action
from ..driver import ActionFailed, Place
from .bridge import Values
from .library import FAILED, Library, LibraryAction, LibraryConfig, Refused, last_of

LOST = ("Connection", "Communication", "EOFError", "imeout")
"""In the names of exceptions after which the instrument is of no use: websockets', Pyro's, RPyC's."""


class PythonConfig(LibraryConfig):
    """The config of `driver: python`."""

    own_errors: ClassVar = {**LibraryConfig.own_errors, **FAILED}

    arguments: list[Any] = Field(default_factory=list)
    close: str = "close"
    abort_beside: bool = False


class Python(Library):
    """Implements whichever contract its lab says or names."""

    config_model: ClassVar = PythonConfig
    library: ClassVar = "Python"

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.stops_beside = self.config.abort_beside

    def connect(self) -> Any:
        config = self.config
        module, _, name = config.instrument.rpartition(".")
        try:
            there = import_module(module)
        except ModuleNotFoundError as fault:
            raise OSError(
                f"{fault}. It has to be installed in the Python that serves the device (`python:` of "
                f"the lab names another), or be a file beside the lab"
            ) from fault
        found = getattr(there, name, None)
        if found is None:
            known = sorted(n for n, one in vars(there).items() if isinstance(one, type))
            raise OSError(f"{module} has no {name}; it has {', '.join(known) or 'no classes'}")
        self.versions = _version(module.partition(".")[0])
        return found(*config.arguments, **config.options)

    def disconnect(self, instrument: Any) -> Any:
        """Not every class has something that closes it."""
        close = getattr(instrument, self.config.close, None)
        return close() if callable(close) else None

    def answers(self, said: LibraryAction) -> bool:
        return bool(said.returns)

    def call(self, path: str, values: Values, action: Action) -> Any:
        """By name; to a method that does not tell its names (one of C++, say), in the lab's order."""
        try:
            method = last_of(self._instrument, path)
        except (AttributeError, LookupError) as fault:
            raise Refused(f"there is nothing to call: {fault}") from fault
        told = _signature(method)
        if told is None:
            return method(*(values[name] for name in action.param_schemas() if name in values))
        try:
            told.bind(**values)
        except TypeError as fault:
            raise Refused(f"it takes {told}: {fault}") from fault
        return method(**values)

    def meaning(self, path: str, fault: Exception, action: Action) -> Exception:
        if isinstance(fault, (OSError, Refused)):
            return fault
        words = f"{type(fault).__name__}: {fault}"
        named = self.named(LibraryAction(call=path), None, words)
        if named is None and _is_lost(fault):
            return fault
        name = named[0] if named is not None else "Failed"
        if name == "Lost":
            return ConnectionError(words)
        return ActionFailed(name, f"{path}: {words}")


def _is_lost(fault: Exception) -> bool:
    """Whether a class of a library's own says that there is no connection, or that nothing came."""
    kinds = " ".join(one.__name__ for one in type(fault).__mro__)
    return any(one in kinds for one in LOST)


def _signature(method: Any) -> inspect.Signature | None:
    """How a method is called; None where it does not tell its names."""
    try:
        told = inspect.signature(method)
    except (TypeError, ValueError):
        return None
    kinds = {one.kind for one in told.parameters.values()}
    some = inspect.Parameter.VAR_POSITIONAL  # with **kwargs beside it: it hands on what it is given
    nameless = inspect.Parameter.POSITIONAL_ONLY in kinds or (
        some in kinds and kinds <= {some, inspect.Parameter.VAR_KEYWORD}
    )
    return None if nameless else told


def _version(module: str) -> dict[str, str]:
    try:
        return {module: version(packages_distributions().get(module, [module])[0])}
    except PackageNotFoundError:  # a file beside the lab
        return {}
