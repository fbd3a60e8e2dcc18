"""The driver keeps gantry@2 on a real server, in front of a chain of stages."""

from contextlib import contextmanager
from dataclasses import replace

import pytest

from ..gantry_calls import KeepsGantryContract, case_of
from .peer import config_of

OUTPUTS = {"outputs": {"laser": {"on": "1 io set do 1 1", "off": "1 io set do 1 0"}}}


@pytest.mark.needs("zaber")
@pytest.mark.soak
class TestZaber(KeepsGantryContract):
    case = replace(case_of("zaber"), config=OUTPUTS)

    @classmethod
    def _about(cls, test):
        return [name for name in super()._about(test) if name != "touch"]  # it is NotAvailable

    @pytest.fixture(autouse=True)
    def _chains(self, peers):
        self.peers = peers

    @contextmanager
    def peer(self, folder, *, slow):
        self.controller = self.peers(speed=12 if slow else 500)
        if slow:
            for axis in self.controller.axes.values():
                axis.place += 80_000
        yield config_of(self.controller)

    def is_safe(self, status):
        stands = all(axis.target is None for axis in self.controller.axes.values())
        return stands and status["state"] in ("idle", "alarm")

    def happened(self, folder, goal_id):
        """The peer knows of no goals: after homing only what the test did moves it."""
        homed = [axis for axis in self.controller.axes.values() if not axis.flags & {"WR"}]
        return any(axis.place for axis in homed) or bool(list(folder.rglob("work_zero.json")))
