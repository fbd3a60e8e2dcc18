"""What a program of labrun does before its imports, so that a start costs only what it uses."""

import gc
import os
import re
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from importlib import import_module
from types import ModuleType
from typing import Any


def spare_plugins() -> None:
    """Let pydantic not look through every installed package for plug-ins; labrun has no use for them."""
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    with later("importlib.metadata", "entry_points"), later("secrets"):
        import_module("pydantic.plugin._loader")
        import_module("pydantic.types")


@contextmanager
def collector_at_rest() -> Iterator[None]:
    """Pause garbage collection where many lasting objects are made; it took a third of the time."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


@contextmanager
def patterns_when_used() -> Iterator[None]:
    """In the block, `re.compile` gives patterns that are compiled when something of them is first used.

    A program imports hundreds and a short one uses few; a single one of PyYAML's would take a
    fifteenth of a check.
    """
    re.compile = _Pattern  # pyright: ignore[reportAttributeAccessIssue]
    try:
        yield
    finally:
        re.compile = _compile


_compile = re.compile


class _Pattern:
    def __init__(self, pattern: Any, flags: Any = 0) -> None:
        self._of = (pattern, flags)

    def __getattr__(self, name: str) -> Any:
        found = getattr(_compile(*self._of), name)
        setattr(self, name, found)  # the next time it is there
        return found


@contextmanager
def without(library: str, everywhere: bool = False) -> Iterator[None]:
    """In the block this thread (or every one) does not find a library, unless it is loaded."""
    here = threading.get_ident()

    class Refusal:
        @staticmethod
        def find_spec(name: str, *_: object) -> None:
            if name == library and (everywhere or threading.get_ident() == here):
                raise ModuleNotFoundError(name=name)

    sys.meta_path.insert(0, Refusal)  # pyright: ignore[reportArgumentType]
    try:
        yield
    finally:
        sys.meta_path.remove(Refusal)  # pyright: ignore[reportArgumentType]


@contextmanager
def later(name: str, *functions: str) -> Iterator[None]:
    """What is imported in the block gets a module that is loaded when something in it is first asked for.

    `functions` may be imported from it by name; they load it when they are called.
    """
    if name in sys.modules:
        yield
        return
    stand_in = _Later(name)
    for function in functions:
        setattr(stand_in, function, partial(stand_in.call, function))
    sys.modules[name] = stand_in
    try:
        yield
    finally:
        stand_in.leave()


def spare_of_socketio(*more: str) -> None:
    """Load Socket.IO without what its other clients and servers would use: half of what it takes."""
    with ExitStack() as spared:
        for library in ("requests", "tornado", "websocket", *more):
            spared.enter_context(later(library))
        import_module("socketio")


class _Later(ModuleType):
    def leave(self) -> None:
        if sys.modules.get(self.__name__) is self:
            del sys.modules[self.__name__]

    def call(self, function: str, *args: Any, **named: Any) -> Any:
        return self.__getattr__(function)(*args, **named)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):  # the import system asks for `__path__`
            raise AttributeError(name)
        self.leave()
        found = getattr(import_module(self.__name__), name)
        self.__dict__[name] = found  # what is asked for thousands of times is found at once
        return found
