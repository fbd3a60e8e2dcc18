"""The driver keeps gantry@2 on a real server, in front of Marlin."""

from contextlib import contextmanager

import pytest

from ..gantry_calls import KeepsGantryContract, case_of


@pytest.mark.soak
class TestMarlin(KeepsGantryContract):
    case = case_of("marlin")

    @pytest.fixture(autouse=True)
    def _controllers(self, peers):
        self.peers = peers

    @contextmanager
    def peer(self, folder, *, slow):
        peer = self.controller = self.peers(speed=1 if slow else 20, homing_s=3 if slow else 0.2)
        peer.surface = 8.0
        yield {"port": peer.path, "boot_s": 1}

    def happened(self, folder, goal_id):
        """The peer knows of no goals: after homing only what the test did moves it."""
        return len(self.controller.stands) > 2 or bool(list(folder.rglob("work_zero.json")))
