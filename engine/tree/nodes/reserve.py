"""`reserve`: a group that has devices for itself, from before its first step to its last end."""

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ...dispatch.dispatcher import Dispatcher
from ...run.frame import Scope
from ...run.reservations import Reservation
from ...run.run import Run
from .background import Join


class Reserve(Join):
    """Waits until all its devices are its own; over when its steps and its background actions have ended."""

    def __init__(
        self, name: str, run: Run, outer: Scope, inner: Scope, child: Behaviour,
        dispatcher: Dispatcher, devices: frozenset[str],
    ) -> None:  # fmt: skip
        super().__init__(name, run, outer, inner, child)
        self.dispatcher = dispatcher
        self.devices = devices
        self.reservation: Reservation | None = None

    def initialise(self) -> None:
        super().initialise()
        frame = self.inner.frame
        path = f"{frame.path}/{self.name}"
        self.reservation = frame.reservation = self.dispatcher.reservations.ask(
            self.devices, frame.reservation, path
        )
        frame.strand = frame.strand or path
        self.run.requests.again()

    def advance(self) -> None:
        if self.reservation is not None and self.reservation.granted:
            super().advance()

    def terminate(self, new_status: Status) -> None:
        if self.reservation is not None:
            self.dispatcher.reservations.release(self.reservation)
            self.reservation = None
            self.run.requests.again()
