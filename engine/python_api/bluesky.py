"""A lab's devices for bluesky's RunEngine: what it moves, reads and triggers are actions of labrun.

Every action takes the way of `labrun.lab`: checked against contract and limits, under the device's
lease, written in its ledger. bluesky itself is not imported; the objects have what it looks for.
"""

import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

from ...schemas.quantity import magnitude_in
from .lab import Device

Values = dict[str, Any]
JSON = {"number": "number", "integer": "integer", "string": "string", "boolean": "boolean",
        "array": "array"}  # fmt: skip


class Status:
    """The end of an action that has been begun, as bluesky waits for it."""

    def __init__(self, future: "Future[Any]") -> None:
        self._future = future

    def __repr__(self) -> str:
        """What a plan's stop document gives as the reason."""
        fault = self.exception() if self.done else None
        state = "succeeded" if self.success else f"failed: {fault}" if self.done else "goes on"
        return f"<{state}>"

    @property
    def done(self) -> bool:
        return self._future.done()

    @property
    def success(self) -> bool:
        return self.done and self._future.exception() is None

    def exception(self, timeout: float | None = 0.0) -> BaseException | None:
        return self._future.exception(timeout)

    def wait(self, timeout: float | None = None) -> None:
        self._future.result(timeout)

    def add_callback(self, callback: "Callable[[Status], Any]") -> None:
        self._future.add_done_callback(lambda _: callback(self))


class Readable:
    """A device that is read by an action that changes nothing: `Readable(lab.dmm, "voltage")`.

    `trigger` is an action that is done before each reading; `name` stands in the documents.
    """

    parent = None

    def __init__(
        self, device: Device, read: str | None, *, trigger: str | None = None, name: str | None = None
    ) -> None:  # fmt: skip
        if read is not None and device._contract.actions[read].effect != "pure":
            raise ValueError(f"{read} of {device._name} is not pure: a reading must change nothing")
        self.name = name or device._name
        self._device, self._read, self._trigger = device, read, trigger
        self._thread = ThreadPoolExecutor(1, f"bluesky {self.name}")
        self.hints = {"fields": [self._key(field) for field in self._returns()]}

    def _returns(self) -> Values:
        return self._device._contract.actions[str(self._read)].returns.get("properties", {})

    def _found(self) -> Values:
        return getattr(self._device, str(self._read))()

    def _key(self, field: str) -> str:
        return f"{self.name}_{field}"

    def read(self) -> dict[str, Values]:
        """Field -> value and time, in the contract's units."""
        found, now = self._found(), time.time()
        plain = {n: getattr(found[n], "magnitude", found[n]) for n in self._returns() if n in found}
        return {self._key(n): {"value": v, "timestamp": now} for n, v in plain.items()}

    def describe(self) -> dict[str, Values]:
        """Field -> its type, unit and source, from the contract."""
        made: dict[str, Values] = {}
        for field, schema in self._returns().items():
            kinds = schema.get("type", "number")
            kind = kinds if isinstance(kinds, str) else kinds[0]
            made[self._key(field)] = {
                "source": f"labrun:{self._device._name}", "dtype": JSON[kind],
                "shape": [None] if kind == "array" else [], "units": schema.get("unit", ""),
            }  # fmt: skip
        return made

    def read_configuration(self) -> Values:
        return {}

    def describe_configuration(self) -> Values:
        return {}

    def trigger(self) -> Status:
        """Do the action before a reading, if there is one."""
        if self._trigger is None:
            nothing: Future[None] = Future()
            nothing.set_result(None)
            return Status(nothing)
        return Status(self._thread.submit(getattr(self._device, self._trigger)))


class Movable(Readable):
    """A device that is set by an action with a parameter: `Movable(lab.gantry, "move_to", "x")`.

    It is read by `read`; without one, by what the move returned, or else by what it was set to, so not
    before the first move.
    """

    def __init__(
        self, device: Device, move: str, parameter: str, read: str | None = None, *, name: str | None = None
    ) -> None:  # fmt: skip
        self._move, self._parameter, self._last = move, parameter, dict[str, Any]()
        super().__init__(device, read, name=name)

    def _returns(self) -> Values:
        action = self._device._contract.actions[self._read or self._move]
        fields = action.returns.get("properties", {})
        if self._read is None:
            fields = {self._parameter: action.param_schemas()[self._parameter]} | fields
        return {n: s for n, s in fields.items() if n == self._parameter} or fields

    def _found(self) -> Values:
        if self._read is None and not self._last:
            raise ValueError(
                f"{self.name} has not moved yet, and no action of it was named as `read`"
            )
        return super()._found() if self._read else self._last

    def set(self, value: Any) -> Status:
        """Begin to move there."""

        def move() -> None:
            unit = (
                self._device._contract.actions[self._move]
                .param_schemas()[self._parameter]
                .get("unit")
            )
            found = getattr(self._device, self._move)(**{self._parameter: value})
            self._last = {self._parameter: magnitude_in(value, unit) if unit else value} | found

        return Status(self._thread.submit(move))

    def stop(self, *, success: bool = False) -> None:
        """Cancel what moves; the action's contract says how it ends."""
        self._device._lab._session.cancel(self._device._name, "bluesky stopped it")
