"""The driver keeps gantry@2 on a real server, in front of a GRBL controller."""

from contextlib import contextmanager

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract

from ..gantry_calls import BAD, CONFIG, GOOD, NEEDS


@pytest.mark.slow
class TestGrbl(KeepsContract):
    case = Case(
        driver="grbl",
        good=GOOD,
        config=CONFIG,
        bad=BAD,
        needs=NEEDS,
        quick=frozenset({"set_zero"}),
        lasting="move_to",
    )

    @pytest.fixture(autouse=True)
    def _controllers(self, peers):
        self.peers = peers

    @contextmanager
    def peer(self, folder, *, slow):
        self.controller = self.peers(speed=1 if slow else 20, homing_s=3 if slow else None)
        self.controller.surface = -80.0
        yield {"port": self.controller.path}

    def is_safe(self, status):
        return self.controller.move is None and status["state"] in ("idle", "alarm")

    def happened(self, folder, goal_id):
        """A controller knows of no goals: after homing only what the test did moves it."""
        return len(self.controller.stands) > 1 or any(self.controller.offset)
