"""The bridges that speak in lines keep a contract that stands apart, kills included."""

import json
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract

from .instruments import running_peer

CONTRACT = Path(__file__).parent / "pump.yaml"
GOOD = {"voltage": {}, "count": {}, "sweep": {}, "dispense": {"volume": 2.5}, "last_once": {}}
SCPI = {
    "abort": "ABOR",
    "timeout": "8 s",
    "actions": {
        "voltage": {"query": "MEAS:VOLT:DC?"},
        "count": {"query": "COUN?"},
        "sweep": {"write": "INIT", "wait": True, "cancel": True},
        "dispense": {"write": "DISP {volume:.1f} {goal}", "wait": True, "count": "count"},
    },
}
TEXT = {
    "abort": "ABOR",
    "timeout": "8 s",
    "actions": {
        "voltage": {"send": "MEAS:VOLT:DC?"},
        "count": {"send": "COUN?"},
        "sweep": {"send": ["INIT", "*OPC?"], "answer": "1", "cancel": True},
        "dispense": {
            "send": ["DISP {volume:.1f} {goal}", "*OPC?"],
            "answer": "1",
            "count": "count",
        },
    },
}


class Pump(KeepsContract):
    """What both have in common: the pump, and what it has really done."""

    @contextmanager
    def peer(self, folder, *, slow):
        habits = {"work_s": 2.6 if slow else 0.0, "over": self.over}
        with running_peer(folder / "pump", **habits) as there:
            yield {"resource": there.where}

    def happened(self, folder, goal_id):
        lines = (folder / "pump" / "done.jsonl").read_text("utf-8").splitlines()
        return any(goal_id in json.loads(line).get("given", "") for line in lines)

    def rest(self, folder):
        time.sleep(3.0)


@pytest.mark.slow
class TestScpiOverTcp(Pump):
    case = Case(
        driver="scpi", contract=CONTRACT, config=SCPI, good=GOOD, lasting="sweep", device="pump"
    )
    over = "tcp"


@pytest.mark.slow
class TestTextOverASerialLine(Pump):
    case = Case(
        driver="text", contract=CONTRACT, config=TEXT, good=GOOD, lasting="sweep", device="pump"
    )
    over = "pty"
