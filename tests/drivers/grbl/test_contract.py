"""The driver keeps gantry@2 on a real server, in front of a GRBL controller."""

from contextlib import contextmanager

import pytest

from ..gantry_calls import KeepsGantryContract, case_of


@pytest.mark.slow
class TestGrbl(KeepsGantryContract):
    case = case_of("grbl")

    @pytest.fixture(autouse=True)
    def _controllers(self, peers):
        self.peers = peers

    @contextmanager
    def peer(self, folder, *, slow):
        yield {"port": self.started(self.peers, slow=slow).path}
