"""Every promise of the analyser's contract, kept with mouse and keyboard on a real program."""

import time
from contextlib import contextmanager

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract


@pytest.mark.slow
class TestSciapsGui(KeepsContract):
    case = Case(
        driver="sciaps_gui",
        good={
            "measure": {}, "last_shot": {}, "export": {"shot": "shot-000001", "file": "s/a.csv"},
            "disarm": {}, "locate": {}, "reconnect": {},
        },
        needs={"export": ["measure"]},
        lasting="measure",
    )  # fmt: skip

    @pytest.fixture(autouse=True)
    def bench(self, gui):
        self.gui = gui

    @contextmanager
    def peer(self, folder, *, slow):
        self.analyser = self.gui.start(measure_s=4.0 if slow else 0.2)
        try:
            yield self.gui.config(measure_s=20)
        finally:
            self.gui.end()

    def is_safe(self, status):
        return status["armed"] is False

    def happened(self, folder, goal_id):
        return self.analyser.shots() == 1

    def rest(self, folder):
        while self.analyser.order("state") == "busy":
            time.sleep(0.05)
