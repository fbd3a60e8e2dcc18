"""Every bridge keeps the contract that its config says, on an instrument of its own process: kills included.

Those to libraries are run by hand, each in an environment of its own; `test_contract.py` has the two that
speak in lines. PyLabRobot's simulator lives in the driver's process, so nothing is left to be asked.
"""

import json
import os
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract
from labrun.drivers.find import find_driver

from .instruments import PEERS, running_peer
from .test_http import ACTIONS
from .test_six_worlds import FURNACE, MOTOR, SHAKER, free_port

pytestmark = [
    pytest.mark.soak,
    pytest.mark.filterwarnings("default"),  # what the libraries warn of is their own matter
]
INTEGER = {"type": "integer"}
CHAMBER = "DeviceSet/Oven/FunctionalUnitSet/Chamber"
HTTP = {
    "abort": "stop", "poll": 0.05, "timeout": "8 s",
    "actions": {name: ACTIONS[name] for name in ("state", "count", "set_speed", "shake", "stop")},
}  # fmt: skip
OVEN = {
    "timeout": "8 s", "poll": 0.05,
    "actions": {
        "doses": {"get": f"{CHAMBER}/Doses", "returns": {"value": INTEGER}},
        "busy": {"get": f"{CHAMBER}/Busy", "returns": {"value": {"type": "boolean"}}},
        "heat": {
            "set": f"{CHAMBER}/TemperatureController/TargetValue", "effect": "idempotent",
            "params": {"value": {"unit": "degC", "minimum": 0, "maximum": 1200}},
        },
        "dose": {
            "call": f"{CHAMBER}/Dose", "count": "doses", "until": {"do": "busy", "value": False},
            "params": {"label": {"type": "string"}, "amount": {"minimum": 0, "maximum": 10}},
        },
    },
}  # fmt: skip
PUMP = {
    "timeout": "8 s",
    "actions": {
        "voltage": {"get": "voltage", "returns": {"voltage": {"unit": "V"}}},
        "count": {"get": "count", "returns": {"count": INTEGER}},
        "set_range": {
            "set": "range", "effect": "idempotent",
            "params": {"to": {"unit": "V", "minimum": 1, "maximum": 100}},
        },
        "dispense": {"call": "dispense", "count": "count", "params": {"volume": {"unit": "ml"}}},
    },
}  # fmt: skip
PUMPED = {
    "voltage": {},
    "count": {},
    "set_range": {"to": 10.0},
    "dispense": {"volume": 2.5},
    "last_once": {},
}


def case(driver, said, address, good, lasting):
    """The contract is what the config says."""
    model = find_driver(driver, Path()).config_model
    contract = model.model_validate({**said, **address}).contract(f"{driver}@1")
    return Case(
        driver=driver, contract=contract, config=said, good=good, lasting=lasting, device=driver
    )


class Bridged(KeepsContract):
    """What they have in common: `program` is the peer, `where` the key of the config that finds it."""

    program = "line_peer.py"
    where = "resource"

    @contextmanager
    def peer(self, folder, *, slow):
        with running_peer(folder / "peer", self.program, work_s=2.6 if slow else 0.0) as there:
            yield {self.where: self.address(there.where)}

    def address(self, where):
        return where

    def happened(self, folder, goal_id):
        lines = (folder / "peer" / "done.jsonl").read_text("utf-8").splitlines()
        return any(json.loads(line)["done"] == "dispense" for line in lines)

    def rest(self, folder):
        time.sleep(3.0)


class OfClass(Bridged):
    """The class is in a file of the tests, `library_meters.py`."""

    @contextmanager
    def peer(self, folder, *, slow):
        with pytest.MonkeyPatch.context() as patch, super().peer(folder, slow=slow) as there:
            patch.setenv(
                "PYTHONPATH", os.pathsep.join([str(PEERS), os.environ.get("PYTHONPATH", "")])
            )
            patch.syspath_prepend(PEERS)  # for the tests that serve it in their own process
            yield there


class OverVisa(OfClass):
    def address(self, where):
        host, _, port = where.partition(":")
        return f"TCPIP::{host}::{port}::SOCKET"


class TestPython(OfClass):
    where = "arguments"
    case = case(
        "python", {**PUMP, "instrument": "library_meters.SocketPump"}, {}, PUMPED, "dispense"
    )

    def address(self, where):
        return [where]


class TestModbus(Bridged):
    program = "modbus_peer.py"
    case = case(
        "modbus", {**FURNACE, "timeout": "8 s"}, {"resource": "a:1"},
        {"count": {}, "state": {}, "heat": {"to": 100.0}, "dose": {}, "last_once": {}}, "dose",
    )  # fmt: skip


class TestHttp(Bridged):
    program, where = "http_peer.py", "url"
    case = case(
        "http", HTTP, {"url": "http://a"},
        {"state": {}, "count": {}, "set_speed": {"speed": 100.0}, "shake": {}, "stop": {}, "last_once": {}},
        "shake",
    )  # fmt: skip


@pytest.mark.needs("sila2")
class TestSila2(Bridged):
    program, where = "sila_peer.py", "url"
    case = case(
        "sila2", SHAKER, {"url": "sila2://a:1"},
        {"count": {}, "shake": {"label": "a"}, "last_once": {}}, "shake",
    )  # fmt: skip


@pytest.mark.needs("asyncua")
class TestOpcua(Bridged):
    program, where = "opcua_peer.py", "url"
    case = case(
        "opcua", OVEN, {"url": "opc.tcp://a:1"},
        {"doses": {}, "busy": {}, "heat": {"value": 100.0}, "dose": {"label": "a", "amount": 1.0},
         "last_once": {}},
        "dose",
    )  # fmt: skip


@pytest.mark.needs("ophyd")
class TestOphyd(Bridged):
    program = "motor_peer.py"
    case = case(
        "ophyd", {**MOTOR, "abort": "stop"}, {}, {"move": {"new_position": 5.0}, "stop": {}}, "move"
    )  # fmt: skip

    @pytest.fixture(scope="class", autouse=True)
    def ioc(self, tmp_path_factory):
        """One for all tests: a process looks only once at where EPICS is."""
        names = ("EPICS_CA_SERVER_PORT", "EPICS_CA_ADDR_LIST", "EPICS_CA_AUTO_ADDR_LIST")
        with pytest.MonkeyPatch.context() as patch:
            for name, value in zip(names, (free_port(), "127.0.0.1", "NO"), strict=True):
                patch.setenv(name, value)
            with running_peer(tmp_path_factory.mktemp("ioc"), self.program, work_s=2.6):
                yield

    @contextmanager
    def peer(self, folder, *, slow):
        yield {}


@pytest.mark.needs("pymeasure")
class TestPymeasure(OverVisa):
    case = case(
        "pymeasure", {**PUMP, "instrument": "library_meters.pymeasure_pump"}, {"resource": "x"},
        PUMPED, "dispense",
    )  # fmt: skip


@pytest.mark.needs("qcodes")
class TestQcodes(OverVisa):
    case = case(
        "qcodes", {**PUMP, "instrument": "library_meters.qcodes_pump"}, {"resource": "x"},
        PUMPED, "dispense",
    )  # fmt: skip
