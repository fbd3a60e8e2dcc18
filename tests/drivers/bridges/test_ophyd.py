"""Devices of ophyd.sim and ophyd_async.sim, and a motor of EPICS' own protocol, where they are installed."""

import asyncio

import pytest

from labrun.drivers.driver import ActionCanceled, ActionFailed, GoalContext
from labrun.engine.lab.lab import load_lab
from labrun.engine.new.device.entry import entry_text
from labrun.engine.new.device.sources import described
from labrun.engine.new.protocol import CannotMake

pytestmark = [
    pytest.mark.needs("ophyd"),
    pytest.mark.filterwarnings("default"),  # what ophyd warns of is its own matter
]


def written(folder, source):
    """The config that is written for a device."""
    entry = entry_text("stage", described(source))
    (folder / "lab.yaml").write_text(f"devices:\n{entry}", "utf-8")
    lab, problems = load_lab(folder / "lab.yaml")

    assert problems == []
    return lab.lab.devices["stage"].config


@pytest.mark.parametrize(
    ("source", "given"),
    [("ophyd:sim.SynAxis", "value"), ("ophyd:ophyd_async.sim.SimMotor", "new_position")],
)
def test_a_motor_of_either_library_moves_and_is_read(tmp_path, once, ask, source, given):
    config = written(tmp_path, source)

    async def story(motor):
        await motor.method("move")(GoalContext("run/move/1"), **{given: 2.5})
        return await motor.method("read")(GoalContext("run/read/1"))

    assert config["actions"]["move"]["effect"] == "idempotent"
    assert config["safe_state"] == ["stop"]
    assert ask("ophyd", config, story)["value"] == 2.5


def test_a_cancelled_move_stops_where_it_is(tmp_path, ask):
    config = written(tmp_path, "ophyd:ophyd_async.sim.SimMotor")
    config["options"] = {"instant": False}

    async def story(motor):
        goal = GoalContext("run/move/1")
        moving = asyncio.create_task(motor.method("move")(goal, new_position=100.0))
        await asyncio.sleep(0.4)
        goal.cancelled.set()
        with pytest.raises(ActionCanceled):
            await moving
        first = await motor.method("read")(GoalContext("run/read/1"))
        await asyncio.sleep(0.3)
        return first["value"], (await motor.method("read")(GoalContext("run/read/2")))["value"]

    where, later = ask("ophyd", config, story)

    assert 0 <= where < 10
    assert later == where


def test_units_and_choices_are_what_the_device_says(tmp_path):
    actions = written(tmp_path, "ophyd:ophyd_async.sim.SimMotor")["actions"]
    noise = written(tmp_path, "ophyd:sim.det")["actions"]["set_noise"]

    assert actions["read_user_readback"]["returns"] == {
        "user_readback": {"type": "number", "unit": "mm"}
    }
    assert noise["params"]["noise"]["enum"] == ["none", "poisson", "uniform"]


def test_what_is_not_connected_is_said(tmp_path, once):
    config = {**written(tmp_path, "ophyd:ophyd.EpicsMotor"), "prefix": "NOBODY:", "timeout": 0.5}
    with pytest.raises(OSError, match=r"Failed to connect|TimeoutError|timed out"):
        once("ophyd", config, "read_velocity")
    with pytest.raises(CannotMake, match=r"nothing answers as NOBODY:; is its IOC on"):
        described("ophyd:ophyd.EpicsMotor@NOBODY:")


def test_a_limit_is_looked_at_before_anything_is_sent(tmp_path, once):
    config = written(tmp_path, "ophyd:sim.SynAxis")
    config["instrument"] = "ophyd.SoftPositioner"
    config["options"] = {"limits": [0, 5], "init_pos": 1}
    with pytest.raises(ActionFailed) as fault:
        once("ophyd", {**config, "actions": {"move": {
            "call": "set", "params": {"new_position": {}}, "effect": "idempotent"},
            "stop": {"call": "stop", "effect": "idempotent"},
        }}, "move", new_position=9.0)  # fmt: skip

    assert (fault.value.name, fault.value.happened) == ("Rejected", "no")
