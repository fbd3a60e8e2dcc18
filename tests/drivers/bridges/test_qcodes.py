"""QCoDeS' classes, spoken to through the PyVISA-sim definitions that it ships, where it is installed."""

import pytest

from labrun.drivers.driver import ActionFailed, GoalContext
from labrun.engine.lab.lab import load_lab
from labrun.engine.new.device.entry import entry_text
from labrun.engine.new.device.sources import described

pytestmark = [
    pytest.mark.needs("qcodes"),
    pytest.mark.filterwarnings("default"),  # what QCoDeS warns of is its own matter
]


@pytest.fixture
def config(tmp_path):
    """The config that is written for a Lake Shore 336, at the simulator."""
    entry = entry_text("dmm", described("qcodes:Lakeshore.LakeshoreModel336"))
    (tmp_path / "lab.yaml").write_text(f"devices:\n{entry}", "utf-8")
    lab, problems = load_lab(tmp_path / "lab.yaml")

    assert problems == []
    sim = {"pyvisa_sim_file": "lakeshore_model336.yaml"}
    return {**lab.lab.devices["dmm"].config, "resource": "GPIB::2::INSTR", "options": sim}


def test_units_ranges_choices_and_effects_are_the_librarys(config):
    actions = config["actions"]

    assert actions["read_A_temperature"] == {
        "get": "A.temperature", "returns": {"temperature": {"type": "number", "unit": "K"}},
    }  # fmt: skip
    assert actions["set_output_1_output_range"] == {
        "set": "output_1.output_range", "effect": "idempotent",
        "params": {"output_range": {"type": "string", "enum": ["off", "low", "medium", "high"]}},
    }  # fmt: skip
    assert actions["output_1_wait_until_set_point_reached"]["effect"] == "once"


def test_it_is_read_and_set_through_the_library(config, ask):
    async def story(made):
        await made.method("set_output_1_output_range")(GoalContext("run/1"), output_range="medium")
        chosen = await made.method("read_output_1_output_range")(GoalContext("run/2"))
        return chosen | await made.method("read_A_temperature")(GoalContext("run/3"))

    assert ask("qcodes", config, story) == {"output_range": "medium", "temperature": 100.0}


def test_what_its_validator_refuses_was_not_sent(config, once):
    with pytest.raises(ActionFailed) as fault:
        once("qcodes", config, "set_output_1_output_range", output_range="blazing")

    assert (fault.value.name, fault.value.happened) == ("Rejected", "no")
