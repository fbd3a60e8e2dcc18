"""What comes back from ROS in the contract's words; configurations that cannot be."""

import asyncio
import json
import os
import subprocess
import sys

import pytest
from ruamel.yaml import YAML

from labrun.drivers.driver import ActionFailed, GoalContext, Place
from labrun.drivers.ros_action.bridge import Bridge, Sent
from labrun.drivers.ros_action.config import read_config
from labrun.drivers.ros_action.driver import RosAction
from labrun.schemas.contracts import parse_contract

from .robot import ARM, config, end_robot, start_robot

LAB = """
name: ours
contracts: [./arm.yaml]
devices:
  arm: {{contract: arm@1, driver: ros_action, config: {config}}}
  gantry: {{contract: gantry@1, driver: sim_gantry, config: {{clock: fast, homed: true}}}}
"""
PROTOCOL = """
labrun: 1
name: hand_over
devices: {arm: arm@1, gantry: gantry@1}
steps:
  - parallel:
      - {do: arm.reach, with: {x: 30 cm, y: 5 mm}}
      - {do: gantry.move_to, with: {x: 10 mm}}
  - id: back
    do: arm.reach
    with: {x: 12.5 mm, speed: 1 m/s}
outputs: {x: "${{ steps.back.x }}", y: "${{ steps.back.y }}"}
"""
CONTRACT = parse_contract(ARM, "arm.yaml")


@pytest.fixture(scope="module")
def ours(tmp_path_factory):
    """A lab of ours with the robot in it."""
    from .test_contract import free_port

    folder, port = tmp_path_factory.mktemp("ours"), free_port()
    process = start_robot(folder, port)
    lab = LAB.format(config=json.dumps(config(f"ws://127.0.0.1:{port}")))
    (folder / "lab.yaml").write_text(lab)
    (folder / "protocol.yaml").write_text(PROTOCOL)
    yield folder
    end_robot(folder, process)


def labrun(folder, *arguments):
    return subprocess.run(
        [sys.executable, "-P", "-m", "labrun.engine", *arguments], cwd=folder, text=True,
        capture_output=True, stdin=subprocess.DEVNULL, env=os.environ,
    )  # fmt: skip


@pytest.mark.slow
def test_a_robot_of_ros_takes_part_in_a_protocol(ours):
    done = labrun(ours, "run", "protocol.yaml", "--lab", "lab.yaml", "--json")

    assert done.returncode == 0, done.stdout + done.stderr
    outputs = json.loads(done.stdout.splitlines()[-1])["data"]["outputs"]
    assert outputs == {"x": {"$quantity": [12.5, "mm"]}, "y": {"$quantity": [5.0, "mm"]}}


@pytest.mark.slow
def test_an_aborted_goal_is_the_contracts_error_of_that_name(ours):
    done = labrun(ours, "call", "arm.reach", "x=1200", "speed=500", "--lab", "lab.yaml", "--yes")

    assert done.returncode == 1
    assert "TooFar: 1.2 m is out of reach at 0.5 m/s" in done.stderr


def reached(ours, before, after):
    """How the driver fails by itself, with its configuration changed."""
    lab = (ours / "lab.yaml").read_text().replace(before, after)
    config = YAML(typ="safe").load(lab)["devices"]["arm"]["config"]

    async def main():
        driver = RosAction(Place("arm", config, {}, ours, ours, CONTRACT))
        await driver.open()
        try:
            await driver.reach(GoalContext("g"), x=12)
        finally:
            await driver.close()

    with pytest.raises(ActionFailed) as failed:
        asyncio.run(main())
    return failed.value


def test_an_aborted_goal_of_another_name_is_the_one_that_the_lab_says(ours):
    failed = reached(ours, '"frame": "bench"', '"frame": "moon"')

    assert (failed.name, str(failed)) == ("Stuck", "Stuck: which frame is 'moon'?")


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("arm/reach", "arm/fly", "there is no action /arm/fly"),
        ("RosArmReach", "Fibonacci", "/arm/reach is a labrun_interfaces/action/RosArmReach"),
        ('"field": "target.x"', '"field": "target.u"', "target.u is not a field"),
    ],
)
def test_what_ros_does_not_take_surely_did_not_happen(ours, before, after, words):
    failed = reached(ours, before, after)

    assert (failed.name, failed.happened) == ("Rejected", "no")
    assert words in str(failed)


@pytest.mark.slow
def test_a_bridge_that_is_not_there_is_a_sentence(tmp_path):
    from .test_contract import free_port

    (tmp_path / "arm.yaml").write_text(ARM)
    gone = config(f"ws://127.0.0.1:{free_port()}")
    (tmp_path / "lab.yaml").write_text(LAB.format(config=json.dumps(gone)))
    done = labrun(tmp_path, "call", "arm.reach", "x=12", "--lab", "lab.yaml", "--yes")

    assert done.returncode == 4
    assert "cannot be reached" in done.stderr and "Traceback" not in done.stderr


class Answers(Bridge):
    """A robot that does at once whatever it is sent; `sent` is what arrived."""

    def __init__(self, answer=(4, {"final": {"x": 0.1, "y": 0.1}})):
        self.sent, self.answer = [], answer

    async def open(self): ...
    async def close(self): ...
    async def call(self, service, type, request): ...
    async def cancel_left(self, action, id): ...
    def listen(self, topic, type, heard, qos): ...

    async def serves(self, action, type):
        return True

    @property
    def connected(self):
        return True

    async def send(self, action, type, goal, feedback, id):
        self.sent.append(json.loads(json.dumps(goal)))
        ended = asyncio.get_running_loop().create_future()
        ended.set_result(self.answer)
        return Sent(ended, lambda: None)


def test_no_goal_is_given_a_parameter_of_an_earlier_one(tmp_path):
    reach = config("ws://127.0.0.1:9090")["actions"]["reach"]
    reach["goal"]["speed"] = {"field": "motion.speed", "unit": "m/s"}
    reach["constants"] = {"frame": "bench", "motion": {"acceleration": 0.2}}
    rest = config("")["actions"]["rest"]
    written = changed(actions={"reach": reach, "rest": rest})

    async def main():
        driver = RosAction(Place("arm", written, {}, tmp_path, tmp_path, CONTRACT))
        driver._bridge = robot = Answers()
        await driver.reach(GoalContext("first"), x=1000, speed=500)
        await driver.reach(GoalContext("second"), x=2000)
        return robot.sent

    first, second = asyncio.run(main())

    assert first["motion"] == {"acceleration": 0.2, "speed": 0.5}
    assert second == {"frame": "bench", "motion": {"acceleration": 0.2}, "target": {"x": 2.0}}


def opened(tmp_path, answer):
    driver = RosAction(Place("arm", changed(), {}, tmp_path, tmp_path, CONTRACT))
    driver._bridge = Answers(answer)
    return driver


def test_a_goal_of_which_the_server_knows_nothing_any_more_has_not_succeeded(tmp_path):
    async def main():
        driver = opened(tmp_path, (0, {"final": {"x": 0.0, "y": 0.0}}))
        with pytest.raises(ActionFailed, match="ended with the status 0") as failed:
            await driver.reach(GoalContext("first"), x=1000)
        return failed.value

    failed = asyncio.run(main())

    assert (failed.name, failed.happened) == ("Lost", "unknown")


def test_a_value_that_the_robot_does_not_know_any_more_is_not_the_last_one(tmp_path):
    async def main():
        driver = opened(tmp_path, None)
        (topic,) = driver._config.status
        driver._heard(topic, {"pose": {"x": 0.1, "y": 0.2}})
        driver._heard(topic, {"pose": {"x": float("nan"), "y": 0.3}})
        return await driver.status()

    assert asyncio.run(main()) == {"y": pytest.approx(300)}


def changed(**more):
    return {**config("ws://127.0.0.1:9090"), **more}


def with_reach(**more):
    actions = config("ws://127.0.0.1:9090")["actions"]
    return changed(actions={**actions, "reach": {**actions["reach"], **more}})


def without(name):
    return {key: value for key, value in changed().items() if key != name}


def status(**fields):
    return changed(status={"topic": "/s", "type": "a/msg/B", "fields": fields})


BAD = [
    (changed(node=True), "either `bridge: ws://HOST:PORT` or `node: true`"),
    (without("bridge"), "either `bridge: ws://HOST:PORT` or `node: true`"),
    (changed(bridge="http://x"), "is not the address of a rosbridge"),
    (changed(bridge=9090), "is not the address of a rosbridge"),
    (changed(speed=1), "config has no key speed"),
    (
        changed(actions={"rest": {"action": "/a", "type": "b/action/C"}}),
        "reach of arm@1 has no ROS action",
    ),
    (changed(actions=[]), "must be a mapping of names"),
    (changed(actions={"reach": {"action": "/a"}, "rest": {}}), "actions.reach needs `type`"),
    (status(u="v"), "u is not one of state, x, y"),
    (status(x={"field": "v", "unit": "s"}), "mm"),
    (status(x={"fild": "v"}), "write a field's name"),
    (
        changed(actions={"reach": {"action": "/a", "service": "/b", "type": "t"}, "rest": {}}),
        "actions.reach needs `action` or `service`",
    ),
    (with_reach(error={"names": {1: "Burnt"}}), "Burnt is not an error of the contract"),
    (with_reach(error={"cod": "x"}), "error has no key cod"),
    (with_reach(feedback={"message": "{a..b} m"}), "is not a place in a message"),
    (with_reach(answer_s=0), "is not a number of seconds above 0"),
    (changed(gone_s="soon"), "gone_s: 'soon' is not a number of seconds"),
    (
        changed(status={"topic": "/s", "type": "a/msg/B", "qos": {"depth": 1}}),
        "qos is for `node: true`",
    ),
]


def test_an_action_with_the_name_of_a_drivers_own_is_refused():
    contract = parse_contract("type: door@1\nactions: {open: {effect: idempotent}}\n", "door.yaml")

    with pytest.raises(ValueError, match="cannot be named open"):
        read_config({"bridge": "ws://x", "actions": {}}, contract)


@pytest.mark.parametrize(("written", "words"), BAD)
def test_a_configuration_that_does_not_fit_says_where(written, words):
    with pytest.raises(ValueError) as fault:
        read_config(written, CONTRACT)

    assert words in str(fault.value)
