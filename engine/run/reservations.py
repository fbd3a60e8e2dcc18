"""Whose turn it is on a device: reservations of several devices at once, in the order of asking.

Nothing can block for ever. A reservation takes all its devices at once or none; what holds one asks for no
device of another (the checker sees to that); a single action holds its device until it ends, and asks for
nothing meanwhile. Whoever asks first comes first: a later reservation passes an earlier one only
where they have no device in common, or where it is within what the earlier one waits for.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass


@dataclass(slots=True, eq=False)
class Reservation:
    """Devices for one group alone; `within` is the reservation around it, `asked` its place in the order."""

    devices: frozenset[str]
    within: "Reservation | None"
    asked: int
    path: str = ""
    granted: bool = False
    over: bool = False

    def chain(self) -> "Iterator[Reservation]":
        """It, and those around it."""
        here: Reservation | None = self
        while here is not None:
            yield here
            here = here.within


class Reservations:
    """The reservations of a run: those that hold, and those that wait."""

    def __init__(self) -> None:
        self.held: list[Reservation] = []
        self.waiting: list[Reservation] = []
        self._asked = 0

    def next(self) -> int:
        """A place in the order of asking."""
        self._asked += 1
        return self._asked

    def ask(
        self, devices: Iterable[str], within: Reservation | None, path: str = ""
    ) -> Reservation:
        """Ask for devices; they are granted by `grant`."""
        while within is not None and within.over:
            within = within.within
        made = Reservation(frozenset(devices), within, self.next(), path)
        self.waiting.append(made)
        return made

    def release(self, reservation: Reservation) -> None:
        """It is over, or no longer wanted."""
        reservation.over = True
        for some in (self.held, self.waiting):
            if reservation in some:
                some.remove(reservation)

    def may_use(self, device: str, reservation: Reservation | None) -> bool:
        """Whether what belongs to a reservation, or to none, may use a device now."""
        chain = list(reservation.chain()) if reservation is not None else []
        return all(one in chain for one in self.held if device in one.devices)

    def grant(self, earlier: Iterable[tuple[int, str, Reservation | None]] = ()) -> bool:
        """Grant what can be; `earlier`: single actions that wait only for their device to be idle.

        Returns whether anything was granted.
        """
        singles, some = list(earlier), False
        for one in list(self.waiting):
            if self._is_free(one) and not self._is_behind(one, singles):
                self.waiting.remove(one)
                self.held.append(one)
                one.granted = some = True
        return some

    def _is_free(self, one: Reservation) -> bool:
        return all(self.may_use(device, one.within) for device in one.devices)

    def _is_behind(
        self, one: Reservation, singles: list[tuple[int, str, Reservation | None]]
    ) -> bool:
        if any(asked < one.asked and device in one.devices for asked, device, _ in singles):
            return True
        return any(
            other.asked < one.asked
            and other.devices & one.devices
            and (one.within is None or one.within in other.chain())
            for other in self.waiting
        )
