"""An oven that asyncua serves, its nodes named as OPC UA LADS does, in a process of its own."""

import pytest

from labrun.drivers.driver import ActionFailed, GoalContext
from labrun.engine.lab.lab import load_lab
from labrun.engine.new.device.entry import entry_text
from labrun.engine.new.device.sources import described

pytestmark = [
    pytest.mark.needs("asyncua"),
    pytest.mark.filterwarnings("default"),  # what the library warns of is its own matter
]
CHAMBER = "DeviceSet/Oven/FunctionalUnitSet/Chamber"
DEGREES = {"type": "number", "unit": "degC"}


@pytest.fixture
def oven(peer, tmp_path):
    """The running peer, and the config that is written for it."""
    there = peer("opcua_peer.py")
    known = described(there.where)
    (tmp_path / "lab.yaml").write_text(f"devices:\n{entry_text('oven', known)}", "utf-8")
    lab, problems = load_lab(tmp_path / "lab.yaml")
    assert problems == []
    config = lab.lab.devices["oven"].config
    config["actions"]["dose"] |= {
        "count": "read_doses",
        "until": {"do": "read_busy", "value": False},
    }
    return there, {**config, "poll": 0.05}


def test_units_ranges_and_effects_are_those_of_its_nodes(oven):
    actions = oven[1]["actions"]

    assert actions["read_current_value"] == {
        "get": f"{CHAMBER}/TemperatureController/CurrentValue", "returns": {"value": DEGREES},
    }  # fmt: skip
    assert "set_current_value" not in actions
    assert actions["set_target_value"] == {
        "set": f"{CHAMBER}/TemperatureController/TargetValue", "effect": "idempotent",
        "params": {"value": {**DEGREES, "minimum": 0, "maximum": 1200}},
    }  # fmt: skip
    assert actions["dose"]["effect"] == "once"
    assert actions["dose"]["params"] == {"label": {"type": "string"}, "amount": {"type": "number"}}


def test_variables_are_read_and_set_and_methods_called(oven, ask):
    there, config = oven

    async def story(made):
        await made.set_target_value(GoalContext("run/1"), value=300)
        dosed = await made.dose(GoalContext("run/2"), label="a", amount=5)
        target = await made.read_target_value(GoalContext("run/3"))
        return target, dosed, (await made.last_once(GoalContext("probe")))["goal_id"]

    told = ask("opcua", config, story)

    assert told == ({"value": 300.0}, {"number": 1}, "run/2")
    assert there.done("dispense") == [{"done": "dispense", "given": "a"}]
    assert {"done": "target", "to": 300.0} in there.done("target")


def test_the_values_in_a_structure_are_results_of_their_own(oven, ask):
    _, config = oven
    number = {"type": "number"}
    assert config["actions"]["weigh"]["returns"] == {
        "mass": {**number, "at": "Result.Mass"},
        "note": {"type": "string", "at": "Result.Note"},
        "all_masses": {"type": "array", "items": number},
    }

    async def story(made):
        return await made.weigh(GoalContext("run/1")), await made.read_last(GoalContext("run/2"))

    assert ask("opcua", config, story) == (
        {"mass": 2.5, "note": "wet", "all_masses": [1.0, 2.0]},
        {"mass": 1.5, "note": "dry"},
    )


def test_its_refusals_have_not_happened_and_its_failures_may_have(oven, once):
    _, config = oven
    lost = {"get": f"{CHAMBER}/Nothing", "returns": {"value": DEGREES}}
    wrong = {"set": f"{CHAMBER}/TemperatureController/CurrentValue", "params": {"value": DEGREES}}
    config["actions"] |= {"lost": lost, "wrong": wrong}
    fates = []
    for action, given in (
        ("lost", {}), ("wrong", {"value": 1}), ("dose", {"label": "a", "amount": 500}),
        ("dose", {"label": "a", "amount": 13}), ("read_broken", {}),
    ):  # fmt: skip
        with pytest.raises(ActionFailed) as failed:
            once("opcua", config, action, **given)
        fates.append((failed.value.name, failed.value.happened, failed.value.message))

    assert [fate[:2] for fate in fates] == [
        ("Rejected", "no"), ("Rejected", "no"), ("Rejected", "no"), ("Failed", "unknown"),
        ("NotANumber", "yes"),
    ]  # fmt: skip
    assert "Chamber has no Nothing; it has TemperatureController, Doses" in fates[0][2]


def test_one_that_is_not_there_is_said(once):
    said = {"url": "opc.tcp://127.0.0.1:9", "actions": {"a": {"get": "A/B"}}}
    with pytest.raises(OSError, match=r"opc\.tcp://127\.0\.0\.1:9: .*Connect"):
        once("opcua", said, "a")
