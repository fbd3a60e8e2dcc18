"""A furnace, from the table in its manual."""

import pytest

from labrun.engine.lab.lab import load_lab
from labrun.engine.new.device.entry import entry_text
from labrun.engine.new.device.sources import described
from labrun.engine.new.protocol import CannotMake

TABLE = """\ufeffName;Table;Address;Type;Scale;Unit;Minimum;Maximum;Access;Summary
Temperature;input;0x64;float32;;°C;;;Read;what it is
Target Value;holding;200;int16;0.1;°C;0;1200;R/W;
Start;holding;400;;;;;;w;
Door open;discrete;3;;;;;;;
"""


@pytest.fixture
def described_as(tmp_path):
    def made(text):
        (tmp_path / "registers.csv").write_text(text, "utf-8")
        return described(f"modbus:{tmp_path / 'registers.csv'}")

    return made


def test_registers_units_ranges_and_effects_are_those_of_the_table(described_as, tmp_path):
    known = described_as(TABLE)
    (tmp_path / "lab.yaml").write_text(f"devices:\n{entry_text('furnace', known)}", "utf-8")
    lab, problems = load_lab(tmp_path / "lab.yaml")
    actions = lab.contracts["furnace@1"].actions

    assert problems == []
    assert lab.lab.devices["furnace"].config["registers"]["temperature"] == {
        "input": 100, "type": "float32",
    }  # fmt: skip
    assert actions["set_target_value"].param_schemas()["target_value"] == {
        "type": "number", "unit": "degC", "minimum": 0, "maximum": 1200,
    }  # fmt: skip
    assert {n: a.effect for n, a in actions.items() if n != "last_once"} == {
        "read_temperature": "pure", "read_target_value": "pure", "set_target_value": "idempotent",
        "set_start": "once", "read_door_open": "pure",
    }  # fmt: skip
    assert known.unsure == {"set_start"}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("name,address\na,1\n", "has no column 'table'"),
        ("name,table,address,colour\na,coil,1,red\n", "has an unknown column 'colour'"),
        ("name,table,address\na,coils,1\nb,reg,1\n", "line 3: 'reg' is no table"),
        ("name,table,address\na,coil,1\na,coil,2\n", "line 3: there are two registers a"),
        ("name,table,address,unit\na,input,1,parsnips\n", "line 2: 'parsnips' is no unit"),
        ("name,table,address,access\na,input,1,rw\n", "line 2: a cannot be written"),
        ("name,table,address,type\na,input,1,float\n", "line 2: .*float"),
    ],
)
def test_what_is_wrong_in_the_table_is_said_with_its_line(described_as, text, words):
    with pytest.raises(CannotMake, match=words):
        described_as(text)
