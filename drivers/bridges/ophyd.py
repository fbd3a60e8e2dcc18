"""Devices of ophyd and ophyd-async, EPICS through them: `get` and `set` are signals, `call` methods.

Classes of ophyd by their short names (`sim.SynAxis`), others by their whole ones (`ophyd.EpicsMotor`,
`ophyd_async.sim.SimMotor`, or a function of your own that returns a device). Devices of ophyd
block, those of ophyd-async run on the server's loop.
"""

import re
from collections.abc import Awaitable
from typing import Any, ClassVar

from ...schemas.contract import Action
from ..driver import ActionFailed
from .answers import NoNumber
from .bridge import Values
from .library import FAILED, Library, LibraryConfig, Refused, instrument_class, last_of

PACKAGE, NAME = "ophyd", "device"
INVALID, INVALID_ASYNC = 3, -1
"""EPICS' alarm severity of a value that means nothing: of a broken sensor, or of a device that is silent.

ophyd-async has its own number for it; its 3 is Tango's, of a value that is changing.
"""


class OphydConfig(LibraryConfig):
    """The config of `driver: ophyd`; `prefix` is that of the device's names in EPICS."""

    own_errors: ClassVar = {**LibraryConfig.own_errors, **FAILED}

    prefix: str | None = None


class Ophyd(Library):
    """Implements whichever contract its lab says or names."""

    config_model: ClassVar = OphydConfig
    extra: ClassVar[str | None] = "ophyd"
    library: ClassVar = "ophyd"
    stops_beside = True

    def connect(self) -> Any:
        found = instrument_class(self.library, PACKAGE, self.config.instrument)
        made = made_device(found, self.config.prefix, self.config.options)
        self.versions = {"instrument": type(made).__name__}
        self.on_loop = hasattr(made, "connect")
        if self.on_loop:
            return self._connected(made)
        if hasattr(made, "wait_for_connection"):
            made.wait_for_connection(timeout=self.timeout_s(None))
        return made

    async def _connected(self, made: Any) -> Any:
        await made.connect(timeout=self.timeout_s(None))
        return made

    def disconnect(self, instrument: Any) -> None:
        if not self.on_loop and instrument.name == NAME:  # not one that its module has made
            instrument.destroy()

    def get(self, path: str) -> Any:
        signal = last_of(self._instrument, path)
        if self.on_loop:
            return self._read(path, signal)
        found = signal.get()
        return valid(path, found, getattr(signal, "alarm_severity", None))

    async def _read(self, path: str, signal: Any) -> Any:
        (reading,) = (await signal.read()).values()
        return valid(path, reading["value"], reading.get("alarm_severity"), INVALID_ASYNC)

    def set(self, path: str, value: Any) -> Any:
        return last_of(self._instrument, path).set(value)

    def _do_it(self, said: Any, action: Action, values: Values) -> Any:
        """What it returns, once a status says that it is done."""
        found = super()._do_it(said, action, values)
        if isinstance(found, Awaitable):
            return self._awaited(found)
        if hasattr(found, "wait") and hasattr(found, "done"):
            found = found.wait(timeout=self.timeout_s(said))
        return readings(found, self._instrument.name)

    async def _awaited(self, found: Awaitable[Any]) -> Any:
        return readings(await found, self._instrument.name, INVALID_ASYNC)

    def call(self, path: str, values: Values, action: Action) -> Any:
        """Readings of ophyd do not tell what EPICS thinks of them; its signals do."""
        found = super().call(path, values, action)
        if self.on_loop or not are_readings(found):
            return found
        told = severities(last_of(self._instrument, path.rpartition(".")[0]))
        return {one: {"alarm_severity": told.get(one), **found[one]} for one in found}

    def meaning(self, path: str, fault: Exception, action: Action) -> Exception:
        """A limit is looked at before anything is sent; a status that failed says so."""
        kind = type(fault).__name__
        if "Limit" in kind:
            return Refused(str(fault))
        if kind in ("UnknownStatusFailure", "RuntimeError", "FailedStatus"):
            return ActionFailed("Failed", str(fault) or kind)
        return fault


def made_device(found: Any, prefix: str | None, options: dict[str, Any]) -> Any:
    """A device of a class or from a function; one with `prefix` is of EPICS."""
    if not callable(found):  # a device that its module has made, as `ophyd.sim.motor`
        return found
    return found(*([] if prefix is None else [prefix]), **{"name": NAME, **options})


def valid(path: str, found: Any, severity: Any, invalid: int = INVALID) -> Any:
    """The value of a signal; a NoNumber where EPICS itself says that it is none."""
    if severity == invalid:
        words = f"EPICS marks {path} as INVALID, and its {found!r} means nothing"
        return NoNumber("NotANumber", f"{words}; look at its sensor and at its cable")
    return found


def severities(owner: Any) -> dict[str, Any]:
    """EPICS' alarm severity of each signal of a device or of one signal, by its name in readings."""
    walk = getattr(owner, "walk_signals", None)
    signals = [owner] if walk is None else [one.item for one in walk()]
    return {
        one.name: getattr(one, "alarm_severity", None) for one in signals if hasattr(one, "name")
    }


def are_readings(found: Any) -> bool:
    """Whether a method has returned readings."""
    return isinstance(found, dict) and all(
        isinstance(one, dict) and "value" in one for one in found.values()
    )


def readings(found: Any, name: str, invalid: int = INVALID) -> Any:
    """`{"device_x": {"value": 1, ...}}` as `{"x": 1}`; what has the device's own name is `value`."""
    if not are_readings(found):
        return found
    return {
        field(one, name): valid(one, reading["value"], reading.get("alarm_severity"), invalid)
        for one, reading in found.items()
    }


def field(reading: str, name: str) -> str:
    """The name of a reading, without that of its device."""
    plain = reading.removeprefix(name).strip("_-") or "value"
    return re.sub(r"\W", "_", plain)
