"""Instruments that QCoDeS knows: `get` and `set` are its parameters, `call` its methods.

The classes of QCoDeS by their short names (`Keithley.Keithley2450`), those of other packages by
their whole ones.
"""

from typing import Any, ClassVar

from .library import Library, LibraryAction, LibraryConfig, Refused, instrument_class, last_of

PACKAGE = "qcodes.instrument_drivers"


class QcodesConfig(LibraryConfig):
    """The config of `driver: qcodes`; an instrument that takes no address has no `resource`."""

    resource: str | None = None
    visa_library: str | None = "@py"


class Qcodes(Library):
    """Implements whichever contract its lab says or names."""

    config_model: ClassVar = QcodesConfig
    extra: ClassVar[str | None] = "qcodes"
    library: ClassVar = "QCoDeS"

    def connect(self) -> Any:
        found = instrument_class(self.library, PACKAGE, self.config.instrument)
        from qcodes.instrument import (  # pyright: ignore[reportMissingImports]
            Instrument,
            VisaInstrument,
        )

        options = dict(self.config.options)
        if self.config.resource is not None:
            options.setdefault("address", self.config.resource)
            simulated = "pyvisa_sim_file" in options
            over_visa = isinstance(found, type) and issubclass(found, VisaInstrument)
            if over_visa and self.config.visa_library and not simulated:
                options.setdefault("visalib", self.config.visa_library)
        name = self.place.device
        if Instrument.exist(name):  # it was given up, and has not been closed yet
            Instrument.find_instrument(name).close()
        made = found(name, **options)
        self.versions = {"instrument": type(made).__name__}
        return made

    def disconnect(self, instrument: Any) -> None:
        instrument.close()

    def answers(self, said: LibraryAction) -> bool:
        return bool(said.returns)

    def get(self, path: str) -> Any:
        return last_of(self._instrument, path).get()

    def set(self, path: str, value: Any) -> None:
        parameter = last_of(self._instrument, path)
        value = choice(parameter, value)
        try:
            parameter.validate(value)
        except (TypeError, ValueError) as fault:
            raise Refused(str(fault)) from fault
        parameter.set(value)


def choice(parameter: Any, value: Any) -> Any:
    """The choice that has this value, or that stands behind this text: QCoDeS takes objects, too."""
    allowed = [*(getattr(parameter, "val_mapping", None) or {}), *_listed(parameter.vals)]
    if any(type(one) is type(value) and one == value for one in allowed):
        return value
    return next((one for one in allowed if choice_text(one) == value), value)


def _listed(validator: Any) -> list[Any]:
    parts = getattr(validator, "validators", None) or [validator]
    return [one for part in parts for one in getattr(part, "values", None) or ()]


def choice_text(one: Any) -> Any:
    """A choice as a contract has it."""
    name = getattr(one, "name", None)
    if isinstance(name, str) and not isinstance(one, str):  # a member of an Enum
        return name
    return one if isinstance(one, (bool, int, float, str)) else str(one)
