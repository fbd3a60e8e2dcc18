"""A shaker that the SiLA 2 package serves, in a process of its own."""

import asyncio

import pytest

from labrun.drivers.driver import ActionCanceled, ActionFailed, GoalContext
from labrun.engine.lab.lab import load_lab
from labrun.engine.new.device.entry import entry_text
from labrun.engine.new.device.sources import described
from labrun.engine.new.protocol import CannotMake

pytestmark = [
    pytest.mark.needs("sila2"),
    pytest.mark.filterwarnings("default"),  # what the package and gRPC warn of is their own matter
]


@pytest.fixture
def shaker(peer, tmp_path):
    """The running peer, and the config that is written for it."""

    def made(**habits):
        there = peer("sila_peer.py", **habits)
        known = described(f"{there.where}?insecure")
        (tmp_path / "lab.yaml").write_text(f"devices:\n{entry_text('shaker', known)}", "utf-8")
        lab, problems = load_lab(tmp_path / "lab.yaml")
        assert problems == []
        return there, lab.lab.devices["shaker"].config

    return made


def test_units_ranges_errors_and_effects_are_those_of_its_features(shaker):
    _, config = shaker()
    actions = config["actions"]
    rpm = {"type": "number", "unit": "rpm"}

    assert config["abort"] == "stop_now"
    assert actions["speed"] == {"get": "Shaking.Speed", "returns": {"speed": rpm}}
    assert actions["steps"]["returns"] == {"steps": {"type": "array", "items": rpm}}
    assert actions["set_speed"] == {
        "call": "Shaking.SetSpeed", "effect": "idempotent",
        "params": {"target_speed": {**rpm, "minimum": 0, "maximum": 1500}},
        "errors": {"Unbalanced": {"happened": "unknown", "summary": "The load is unbalanced"}},
    }  # fmt: skip
    assert actions["shake"]["effect"] == "once"
    assert "upload" not in actions  # JSON has no counterpart of binary data


def test_properties_are_read_and_commands_are_waited_for(shaker, ask):
    there, config = shaker(work_s=0.3)
    config["actions"]["shake"]["count"] = "count"

    async def story(made):
        await made.set_speed(GoalContext("run/1"), target_speed=300.0)
        shaken = await made.shake(GoalContext("run/2"), label="a")
        last = await made.last_once(GoalContext("probe"))
        return await made.speed(GoalContext("run/3")), shaken, last["goal_id"]

    told = ask("sila2", config, story)

    assert told == ({"speed": 300.0}, {"turns": 1, "note": "a"}, "run/2")
    assert [one["done"] for one in there.done()] == ["on", "speed", "dispense"]


def test_the_values_in_a_structure_are_results_of_their_own(shaker, ask):
    """And what comes meanwhile of a command is not waited for."""
    _, config = shaker()
    rpm = {"type": "number", "unit": "rpm"}
    assert config["actions"]["weigh"]["returns"] == {
        "mass": {**rpm, "at": "Result.Mass"},
        "stable": {"type": "boolean", "at": "Result.Stable"},
    }

    async def story(made):
        weighed = await made.weigh(GoalContext("run/1"), label="a")
        return weighed, await made.climate(GoalContext("run/2"))

    told = ask("sila2", config, story)

    assert told == ({"mass": 2.5, "stable": True}, {"damp": 40.0, "note": "dry"})


def test_its_errors_are_named_and_what_it_refuses_has_not_happened(shaker, once):
    there, config = shaker()
    with pytest.raises(ActionFailed, match="balance it") as named:
        once("sila2", config, "set_speed", target_speed=1313.0)
    with pytest.raises(ActionFailed, match="Constraint violated") as refused:
        once("sila2", config, "set_speed", target_speed=5000.0)

    assert named.value.name == "Unbalanced"
    assert (refused.value.name, refused.value.happened) == ("Rejected", "no")
    assert there.done("speed") == []


def test_a_command_is_ended_by_another(shaker, ask):
    there, config = shaker(work_s=60)
    config["actions"]["shake"]["cancel"] = True

    async def story(made):
        goal = GoalContext("run/1")
        shaking = asyncio.ensure_future(made.shake(goal, label="a"))
        await asyncio.sleep(1)
        goal.cancelled.set()
        with pytest.raises(ActionCanceled):
            await shaking

    ask("sila2", config, story)

    assert there.done("dispense") == []
    assert len(there.done("stop")) == 1


def test_a_server_with_a_certificate_of_its_own(peer, once):
    there = peer("sila_peer.py", certificate=True)
    with pytest.raises(CannotMake, match="root_certs=FILE"):
        described(there.where)
    known = described(f"{there.where}?root_certs={there.folder / 'ca.pem'}")

    assert known.config["root_certs"] == str(there.folder / "ca.pem")
    assert once("sila2", {**known.config, "actions": known.actions}, "count") == {"count": 0}


def test_one_that_is_not_there_is_said(once):
    said = {"url": "sila2://127.0.0.1:9", "insecure": True}
    with pytest.raises(OSError, match=r"sila2://127\.0\.0\.1:9: .*Failed to establish"):
        once("sila2", {**said, "actions": {"a": {"get": "A.B"}}}, "a")
