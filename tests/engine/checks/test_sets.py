"""Two actions of one device in a set: what to do instead depends on what they are."""

import pytest

from labrun.engine.check import check_file, check_text

FURNACE = """type: oven@1
status: {type: object, properties: {temperature: {type: number, unit: degC}}}
actions:
  ramp:
    params: {type: object, properties: {to: {type: number, unit: degC}}, required: [to]}
    effect: idempotent
    duration: 1 h
  read:
    returns: {type: object, properties: {temperature: {type: number, unit: degC}}}
    effect: pure
    duration: 1 s
"""
LAB = """name: heat
contracts: [./furnace.yaml]
devices: {furnace: {contract: oven@1, url: "http://127.0.0.1:9"}}
"""


def heat(tmp_path, steps):
    (tmp_path / "furnace.yaml").write_text(FURNACE)
    (tmp_path / "lab.yaml").write_text(LAB)
    (tmp_path / "heat.yaml").write_text(
        f"labrun: 1\nname: heat\ndevices: {{furnace: oven@1}}\nsteps:\n{steps}"
    )
    return check_file(tmp_path / "heat.yaml", lab=tmp_path / "lab.yaml").problems


def test_a_device_that_is_to_be_read_while_it_works_is_told_another_way_than_one_after_the_other(
    tmp_path,
):
    (found,) = heat(
        tmp_path,
        "  - parallel:\n      - {do: furnace.ramp, with: {to: 900 degC}}\n      - do: furnace.read\n",
    )

    assert found.code == "E402"
    assert "reads after each" in found.hint
    assert "concurrent: true" in found.hint


def test_two_actions_that_both_act_are_two_steps():
    steps = "  - parallel: [{do: gantry.home}, {do: gantry.home}]\n"
    text = f"labrun: 1\nname: p\ndevices: {{gantry: gantry@1}}\nsteps:\n{steps}"

    assert [p.hint for p in check_text(text, "p.yaml").problems if p.code == "E402"] == [
        "make them two steps, one after the other"
    ]


SETTLED = """  - {id: a, do: furnace.read}
  - {id: b, do: furnace.read}
  - {require: "${{ abs(steps.b.temperature - steps.a.temperature) < 1 K }}"}
  - {require: "${{ steps.b.temperature > -20 degC }}"}
"""


def test_settled_to_a_kelvin_can_be_said_and_a_temperature_below_zero_too(tmp_path):
    assert heat(tmp_path, SETTLED) == []


@pytest.mark.parametrize(
    "apart",
    [
        "steps.b.temperature - steps.a.temperature",
        "0.5 * (steps.b.temperature - 20 degC)",
        "30 degC - 20 degC",
    ],
)
def test_a_difference_of_temperatures_is_no_temperature_to_go_to(apart, tmp_path):
    steps = f"{SETTLED}  - {{do: furnace.ramp, with: {{to: '${{{{ {apart} }}}}'}}}}\n"
    (found,) = heat(tmp_path, steps)

    assert (found.code, found.line) == ("E204", 9)
    assert "a difference of temperatures" in found.message
