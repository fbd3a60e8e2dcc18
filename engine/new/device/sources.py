"""What a device can be made from: `labrun new device NAME --from SCHEME:...`, a module each.

A module's `describe(source)` takes the whole text behind `--from`, returns what is known of the
instrument, and raises CannotMake or OSError with a sentence.
"""

import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

from ...language.suggest import did_you_mean
from ..protocol import CannotMake

LONG = {"timeout": "5 min", "duration": "5 s"}
"""Of what a machine does or a motor goes to; what is asked or set takes a moment."""


SOURCES = {
    "pymeasure": "pymeasure:keithley.Keithley2000",
    "qcodes": "qcodes:Keithley.Keithley2450",
    "ophyd": "ophyd:sim.SynAxis",
    "pylabrobot": "pylabrobot:heating_shaking.HeaterShaker",
    "sila2": "sila2://10.0.0.9:50052",
    "opc.tcp": "opc.tcp://10.0.0.9:4840",
    "visa": "visa:GPIB0::22::INSTR",
    "modbus": "modbus:registers.csv",
}
"""Scheme, which is what stands before the first colon -> an example that a refusal shows."""
MODULES = {"opc.tcp": "opcua"}
"""Others are called as their scheme."""


@dataclass(frozen=True, slots=True)
class Described:
    """An instrument as its source knows it, in the words of a lab entry.

    `config` is without `actions`. `notes` explain keys of `config` that only the reader can say.
    """

    driver: str
    config: Mapping[str, Any]
    actions: Mapping[str, Mapping[str, Any]]
    notes: Mapping[str, str] = field(default_factory=dict)

    @property
    def unsure(self) -> set[str]:
        """The actions whose effect nobody knows but the reader: `once` is the cautious guess."""
        return {name for name, said in self.actions.items() if said.get("effect") == "once"}


def described(source: str) -> Described:
    """What its module knows of a source; raises CannotMake."""
    scheme = source.partition(":")[0]
    if scheme not in SOURCES or scheme == source:
        examples = ", ".join(SOURCES.values())
        if source in SOURCES:
            raise CannotMake(
                f"{source!r} says no instrument: write, for example, {SOURCES[source]}"
            )
        raise CannotMake(
            f"{source!r}{did_you_mean(scheme, SOURCES)}: a device can be made from {examples}"
        )
    if (here := str(Path.cwd())) not in sys.path:  # a class in a file beside the lab
        sys.path.append(here)
    try:
        name = f".from_{MODULES.get(scheme, scheme)}"
        return import_module(name, __package__).describe(source)
    except OSError as fault:  # its library, or the instrument, is not there
        raise CannotMake(str(fault)) from fault
