"""Every promise of the analyser's contract, kept by the driver of the paper's server."""

import time
from contextlib import contextmanager

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract


@pytest.mark.slow
class TestAecp(KeepsContract):
    case = Case(
        driver="aecp",
        config={"settle_s": 0.4},
        good={
            "measure": {}, "last_shot": {}, "export": {"shot": "shot-000001", "file": "s/a.csv"},
            "disarm": {}, "locate": {}, "reconnect": {},
        },
        needs={"export": ["measure"]},
        lasting="measure",
    )  # fmt: skip

    @pytest.fixture(autouse=True)
    def bench(self, aecp):
        self.aecp = aecp

    @contextmanager
    def peer(self, folder, *, slow):
        self.aecp.start(shot_s=3.0 if slow else 0.1)
        try:
            yield {
                "url": f"http://127.0.0.1:{self.aecp.port}",
                "exports": str(folder / "exports"),
                "cache": self.aecp.cache,
            }
        finally:
            self.aecp.end()

    def is_safe(self, status):
        return status["armed"] is False

    def happened(self, folder, goal_id):
        return self.aecp.shots() == 1

    def rest(self, folder):
        while (folder / "running").exists():
            time.sleep(0.05)
