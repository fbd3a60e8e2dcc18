"""Stands for a library that blocks: a motor that counts its moves, and can be stopped beside them."""

import threading
from enum import IntEnum

MOVING = threading.Event()
"""A move has begun."""


class ConnectionClosed(Exception):
    """As a library of its own has it: no OSError."""


class Again(Exception):
    """As ZeroMQ has it: nothing came in time, and the socket is of no use any more."""


class LimitError(ValueError):
    """Where the library refuses, before anything moves."""


class Motor:
    """`speed` is a signal; a move lasts as long as it is told to."""

    def __init__(self, name):
        self.name = name
        self.moves = 0
        self._stopped = threading.Event()
        self.speed = Signal(1.0)
        self.gauge = Signal(1.5)
        self.gauge.alarm_severity = 3

    def ask(self, fault):
        self.moves += 1
        raise {"closed": ConnectionClosed, "again": Again, "odd": RuntimeError}[fault](fault)

    def set(self, to, lasts):
        if to > 100:
            raise LimitError(f"{to} is beyond 100")
        self.moves += 1
        self._stopped.clear()
        MOVING.set()
        if self._stopped.wait(lasts):
            raise RuntimeError("it was stopped")

    def stop(self):
        self._stopped.set()

    def read(self):
        return {f"{self.name}_moves": {"value": self.moves, "timestamp": 0.0}}


class Arm:
    """It starts anew in the middle of a pick, which it has counted: twice it cannot be reached."""

    picks, away = 0, 0

    def __init__(self):
        if Arm.away:
            Arm.away -= 1
            raise ConnectionRefusedError("nobody listens")

    def pick(self):
        Arm.picks, Arm.away = Arm.picks + 1, 2
        raise ConnectionClosed("it hung up")


class Signal:
    """A value that is read and set."""

    def __init__(self, value):
        self.value, self.name, self.alarm_severity = value, "device", 0

    def get(self):
        return self.value

    def read(self):
        return {self.name: {"value": self.value, "timestamp": 0.0}}

    def set(self, value):
        self.value = value


class Pair:
    """Two signals of one kind."""

    name = "pair"

    def __init__(self, resource, visa_library):
        self.adapter = self
        self.speed, self.far = Signal(1.0), Signal(1.0)

    def close(self):
        pass


class Source:
    """An instrument as PyMeasure has them: a property, a method, an adapter that is closed."""

    name = "source"

    def __init__(self, resource, visa_library):
        self.adapter = self
        self._volts, self.resets = 0.0, 0
        self.points, self.deaf = 0, False

    @property
    def voltage(self):
        return self._volts

    @voltage.setter
    def voltage(self, value):
        self._volts = value

    def reset(self):
        self.resets += 1

    def trigger(self):
        self.points += not self.deaf

    def close(self):
        pass


class Lamp(IntEnum):
    """What a library numbers, and means by a name."""

    OFF = 0
    SHINING = 10


class Compiled:
    """As one of C++: its methods take values by place alone, and return lists."""

    def __init__(self):
        self._place = [0.0, 0.0]

    def go(self, *given):
        axis, x, y = given
        assert axis == "XY"
        self._place = [x, y]

    def handed_on(self, *given, **_):
        self.go(*given)

    def lamp(self):
        return [Lamp.SHINING, Lamp.SHINING]

    def place(self):
        return self._place
