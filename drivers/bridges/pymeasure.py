"""Instruments that PyMeasure knows: `get` and `set` are its properties, `call` its methods."""

import contextlib
import inspect
import re
from typing import Any, ClassVar

from .library import Library, LibraryAction, LibraryConfig, Refused, instrument_class, last_of

PACKAGE = "pymeasure.instruments"


class PymeasureConfig(LibraryConfig):
    """The config of `driver: pymeasure`."""

    resource: str
    visa_library: str = "@py"


class Pymeasure(Library):
    """Implements whichever contract its lab says or names."""

    config_model: ClassVar = PymeasureConfig
    extra: ClassVar[str | None] = "pymeasure"
    library: ClassVar = "PyMeasure"
    silent_hint: ClassVar = (
        ", or its lines end otherwise: over TCP and serial ports try "
        '`options: {read_termination: "\\n", write_termination: "\\n"}`'
    )

    def connect(self) -> Any:
        made = instrument_class(self.library, PACKAGE, self.config.instrument)(
            self.config.resource, visa_library=self.config.visa_library, **self.config.options
        )
        self.versions = {"instrument": str(made.name)}
        return made

    def disconnect(self, instrument: Any) -> None:
        instrument.adapter.close()

    def answers(self, said: LibraryAction) -> bool:
        return bool(said.returns)

    def set(self, path: str, value: Any) -> None:
        inside, _, name = path.rpartition(".")
        there = inspect.getattr_static(last_of(self._instrument, inside), name, None)
        if isinstance(value, list) and isinstance(there, property) and together(there) > 1:
            value = tuple(value)
        try:
            super().set(path, value)
        except ValueError as fault:  # its validator looks before anything is sent
            number = _number(value)
            if number is None:
                raise Refused(str(fault)) from fault
            self.set(path, number)


def made_of(function: Any) -> dict[str, Any]:
    """What the library's factory gave the function of a property."""
    if function is None:
        return {}
    return {n: p.default for n, p in inspect.signature(function).parameters.items()}


def together(there: property) -> int:
    """How many values a property is set to at once: two for `APPLY %g, %g`."""
    command = str(made_of(there.fset).get("set_command") or "")
    return len(re.findall(r"%[^%a-zA-Z]*[a-zA-Z]", command.replace("%%", "")))


def _number(value: Any) -> int | float | None:
    """What a choice means among words, such as `3` of 3, 20, 200, MIN and MAX; None for a word."""
    for kind in (int, float) if isinstance(value, str) else ():
        with contextlib.suppress(ValueError):
            return kind(value)
    return None
