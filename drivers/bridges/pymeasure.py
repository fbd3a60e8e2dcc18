"""Instruments that PyMeasure knows: `get` and `set` are its properties, `call` its methods."""

import contextlib
from typing import Any, ClassVar

from .library import Library, LibraryAction, LibraryConfig, Refused, instrument_class

PACKAGE = "pymeasure.instruments"


class PymeasureConfig(LibraryConfig):
    """The config of `driver: pymeasure`."""

    resource: str
    visa_library: str = "@py"


class Pymeasure(Library):
    """Implements whichever contract its lab says or names."""

    config_model: ClassVar = PymeasureConfig
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
        try:
            super().set(path, value)
        except ValueError as fault:  # its validator looks before anything is sent
            number = _number(value)
            if number is None:
                raise Refused(str(fault)) from fault
            self.set(path, number)


def _number(value: Any) -> int | float | None:
    """What a choice means among words, such as `3` of 3, 20, 200, MIN and MAX; None for a word."""
    for kind in (int, float) if isinstance(value, str) else ():
        with contextlib.suppress(ValueError):
            return kind(value)
    return None
