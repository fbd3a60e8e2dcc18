"""The frame of the contract tests of libs_analyzer@1's real drivers."""

import time

from labrun.drivers.contract_tests import Case, KeepsContract


def case_of(driver, **config):
    """The contract's tests for a driver in front of an analyser's program."""
    return Case(
        driver=driver, config=config,
        good={
            "measure": {}, "last_shot": {}, "export": {"shot": "shot-000001", "file": "s/a.csv"},
            "disarm": {}, "locate": {}, "reconnect": {},
        },
        needs={"export": ["measure"]}, lasting="measure",
    )  # fmt: skip


class KeepsAnalyserContract(KeepsContract):
    """What an analyser shows of safety, and of shots: `fired` and `is_busy` are the driver's own."""

    def is_safe(self, status):
        return status["armed"] is False

    def happened(self, folder, goal_id):
        return self.fired() == 1

    def rest(self, folder):
        while self.is_busy(folder):
            time.sleep(0.05)
