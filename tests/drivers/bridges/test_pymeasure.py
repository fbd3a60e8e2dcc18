"""PyMeasure's classes, spoken to through PyVISA-sim: in an environment that has PyMeasure."""

import pytest

from labrun.drivers.driver import ActionFailed, GoalContext
from labrun.engine.lab.lab import load_lab
from labrun.engine.new.device.entry import entry_text
from labrun.engine.new.device.sources import described

pytestmark = [
    pytest.mark.needs("pymeasure"),
    pytest.mark.filterwarnings("default"),  # what PyMeasure warns of is its own matter
]
SIMULATED = """
spec: "1.1"
devices:
  meter:
    eom:
      GPIB INSTR: {q: "\\r\\n", r: "\\n"}
    error: ERROR
    dialogues:
      - {q: ":READ?", r: "+1.25000000E+00"}
      - {q: ":FETC?", r: "+1.25000000E+00"}
      - {q: ":SYST:BEEP:STAT?", r: "1"}
    properties:
      range:
        default: 10.0
        getter: {q: ":SENS:VOLT:RANG?", r: "{:.6f}"}
        setter: {q: ":SENS:VOLT:RANG:AUTO 0;:SENS:VOLT:RANG {}"}
        specs: {type: float}
resources:
  GPIB0::22::INSTR: {device: meter}
"""


CHANNELS = """
from pymeasure.instruments import Channel, Instrument

class Zone(Channel):
    target = Channel.control("SP{ch}?", "SP{ch} %g", "Control the target in degC.")

class Brewer(Instrument):
    zones = Instrument.MultiChannelCreator(Zone, [1, 2])
"""


def test_channels_of_a_class_beside_the_lab_are_a_parameter(tmp_path, monkeypatch):
    (tmp_path / "brewer_b7.py").write_text(CHANNELS, "utf-8")
    monkeypatch.chdir(tmp_path)

    assert described("pymeasure:brewer_b7.Brewer").actions["set_ch_target"] == {
        "set": "ch_{channel}.target",
        "params": {
            "channel": {"type": "integer", "enum": [1, 2]}, "target": {"type": "number", "unit": "degC"},
        },
        "effect": "idempotent",
    }  # fmt: skip


MIXED = """
from pymeasure.adapters import ProtocolAdapter
from pymeasure.instruments import Instrument
from pymeasure.instruments.validators import strict_discrete_set

class Meter(Instrument):
    bandwidth = Instrument.control(
        "BW?", "BW %s", "Control it.", validator=strict_discrete_set, values=[3, 20, "MAX"]
    )

    both = Instrument.control("APPLY?", "APPLY %g, %g", "Control voltage and current.")

    def __init__(self, adapter, **given):
        sent = [(b"BW 20", None), (b"BW MAX", None), (b"APPLY 2, 0.5", None)]
        super().__init__(ProtocolAdapter(sent), "meter", includeSCPI=False)
"""


def test_numbers_among_words_are_choices_and_two_values_are_set_at_once(tmp_path, monkeypatch, ask):
    (tmp_path / "meter_m7.py").write_text(MIXED, "utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    actions = described("pymeasure:meter_m7.Meter").actions

    async def story(made):
        for value in ("20", "MAX"):
            await made.method("set_bandwidth")(GoalContext(f"run/{value}"), bandwidth=value)
        with pytest.raises(ActionFailed, match="Rejected"):
            await made.method("set_bandwidth")(GoalContext("run/5"), bandwidth="5")
        await made.method("set_both")(GoalContext("run/both"), both=[2, 0.5])

    ask("pymeasure", {"instrument": "meter_m7.Meter", "resource": "-", "actions": actions}, story)


@pytest.fixture
def config(tmp_path):
    """The config that is written for a Keithley 2000, at the simulator."""
    (tmp_path / "sim.yaml").write_text(SIMULATED, "utf-8")
    entry = entry_text("dmm", described("pymeasure:keithley.Keithley2000"))
    (tmp_path / "lab.yaml").write_text(f"devices:\n{entry}", "utf-8")
    lab, problems = load_lab(tmp_path / "lab.yaml")

    assert problems == []
    assert len(entry.splitlines()) <= 125
    return {**lab.lab.devices["dmm"].config, "visa_library": f"{tmp_path / 'sim.yaml'}@sim"}


def test_units_ranges_choices_and_effects_are_the_librarys(config):
    actions = config["actions"]

    assert actions["set_voltage_range"] == {
        "set": "voltage_range", "effect": "idempotent",
        "params": {"voltage_range": {"type": "number", "unit": "V", "minimum": 0, "maximum": 1010}},
    }  # fmt: skip
    assert actions["read_voltage"] == {
        "get": "voltage", "returns": {"voltage": {"type": "number", "unit": "V"}},
    }  # fmt: skip
    assert actions["set_beep_state"]["params"]["beep_state"]["enum"] == ["enabled", "disabled"]
    assert actions["start_buffer"]["effect"] == "once"


def test_it_is_read_and_set_through_the_library(config, once):
    assert once("pymeasure", config, "read_voltage") == {"voltage": 1.25}
    assert once("pymeasure", config, "read_beep_state") == {"beep_state": "enabled"}
    assert once("pymeasure", config, "set_voltage_range", voltage_range=100.0) == {}


def test_what_it_does_not_answer_is_a_failure(config, once):
    with pytest.raises(ActionFailed) as fault:
        once("pymeasure", config, "read_frequency_digits")

    assert fault.value.name == "BadAnswer"
    assert "'ERROR' is not a number" in fault.value.message
