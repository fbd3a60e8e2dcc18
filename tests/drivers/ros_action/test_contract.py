"""A robot behind ROS keeps a contract as any other device: it is reached by roslibpy."""

import socket
import tempfile
from pathlib import Path

import pytest

from labrun.drivers.contract_tests import Case, KeepsContract

from .robot import ARM, config, end_robot, start_robot

HERE = Path(tempfile.mkdtemp(prefix="labrun-arm-"))
CONTRACT = HERE / "arm.yaml"
CONTRACT.write_text(ARM)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


PORT = free_port()
BRIDGE = f"ws://127.0.0.1:{PORT}"


@pytest.fixture(scope="module", autouse=True)
def robot(tmp_path_factory):
    folder = tmp_path_factory.mktemp("robot")
    process = start_robot(folder, PORT)
    yield
    end_robot(folder, process)


@pytest.mark.slow
class TestRosAction(KeepsContract):
    case = Case(
        driver="ros_action",
        contract=CONTRACT,
        config=config(BRIDGE),
        slow=config(BRIDGE, seconds=4),
        limits={"x": {"maximum": "1500 mm"}},
        good={"reach": {"x": 90, "speed": 100}, "rest": {}},
        bad={"reach": [{"x": 1500.1}, {"y": 1}, {"x": None}]},
        lasting="reach",
    )

    def is_safe(self, status):
        return status["state"] == "IDLE"
