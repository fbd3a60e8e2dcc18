"""The driver keeps gantry@2 on a real server, in front of Moonraker and Klipper."""

from contextlib import contextmanager
from dataclasses import replace

import pytest

from ..gantry_calls import KeepsGantryContract, case_of

OUTPUTS = {
    "outputs": {"laser": {"on": "SET_PIN PIN=laser VALUE=1", "off": "SET_PIN PIN=laser VALUE=0"}}
}


@pytest.mark.soak
class TestMoonraker(KeepsGantryContract):
    case = replace(case_of("moonraker"), config=OUTPUTS)

    @classmethod
    def _about(cls, test):
        return [name for name in super()._about(test) if name != "touch"]  # it is NotAvailable

    @pytest.fixture(autouse=True)
    def _programs(self, peers):
        self.peers = peers

    @contextmanager
    def peer(self, folder, *, slow):
        self.controller = self.peers(speed=40 if slow else 800, homing_s=3 if slow else 0.2)
        yield {"url": self.controller.url}

    def happened(self, folder, goal_id):
        """The peer knows of no goals: after homing only what the test did moves it."""
        return len(self.controller.stands) > 1 or bool(list(folder.rglob("work_zero.json")))
