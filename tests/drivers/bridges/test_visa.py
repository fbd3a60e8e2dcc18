"""Instruments that VISA reaches: the simulator that comes with PyVISA-sim answers."""

import pytest

from labrun.drivers.driver import ActionFailed

SIMULATED = """
spec: "1.1"
devices:
  meter:
    eom:
      GPIB INSTR: {q: "\\n", r: "\\n"}
      USB INSTR: {q: "\\n", r: "\\n"}
    error: ERROR
    dialogues:
      - {q: "*IDN?", r: "SIM,METER,7,1.0"}
      - {q: "MEAS:VOLT:DC?", r: "+1.25000E+00"}
      - {q: "SYST:ERR?", r: "0,No error"}
    properties:
      range:
        default: 10.0
        getter: {q: "VOLT:RANG?", r: "{:.2f}"}
        setter: {q: "VOLT:RANG {:.2f}"}
        specs: {min: 0.1, max: 1000, type: float}
resources:
  GPIB0::9::INSTR: {device: meter}
  USB0::0x1111::0x2222::0x2468::INSTR: {device: meter}
"""
ACTIONS = {
    "voltage": {"query": "MEAS:VOLT:DC?", "returns": {"voltage": {"unit": "V"}}},
    "set_range": {
        "write": "VOLT:RANG {range:.2f}", "params": {"range": {"unit": "V"}}, "effect": "idempotent",
    },
    "range": {"query": "VOLT:RANG?", "returns": {"range": {"unit": "V"}}},
    "silent": {"query": "*CLS", "returns": {"x": {"type": "number"}}, "timeout": "0.3 s"},
}  # fmt: skip


@pytest.fixture
def config(tmp_path):
    path = tmp_path / "sim.yaml"
    path.write_text(SIMULATED, "utf-8")

    def of(resource):
        return {"resource": resource, "visa_library": f"{path}@sim", "actions": ACTIONS}

    return of


@pytest.mark.parametrize("resource", ["GPIB0::9::INSTR", "USB0::0x1111::0x2222::0x2468::INSTR"])
def test_a_meter_by_gpib_and_usb(config, once, resource):
    said = config(resource)

    assert once("scpi", said, "voltage") == {"voltage": 1.25}
    assert once("scpi", said, "set_range", range=2.5) == {}


@pytest.mark.slow
def test_what_is_not_there_is_said(config, once):
    with pytest.raises(OSError, match=r"GPIB0::10::INSTR was sent .\*IDN\?. and was silent"):
        once("scpi", config("GPIB0::10::INSTR"), "voltage")


def test_an_answer_that_is_none_is_a_failure(config, once):
    with pytest.raises(ActionFailed, match="is not a number"):
        once("scpi", config("GPIB0::9::INSTR"), "silent")
