"""Contracts that a lab says itself, and every way to say them wrongly."""

import pytest

from labrun.engine.check import check_text
from labrun.engine.lab.lab import load_lab

LAB = """devices:
  dmm:
    driver: scpi
    config:
      resource: TCPIP::10.0.0.5::5025::SOCKET
      errors: {OutOfRange: {code: -222, happened: no}}
      actions:
        voltage: {query: "MEAS:VOLT:DC?", returns: {voltage: {type: number, unit: V}}}
        set_range: {write: "VOLT:RANG {range:g}", effect: idempotent, sets: range,
                    params: {range: {unit: V, minimum: 0.1, maximum: 1000}}}
        shoot: {write: SHOT}
"""
PROTOCOL = """labrun: 1
name: read
devices: {dmm: dmm@1}
steps:
  - {do: dmm.set_range, with: {range: 100 V}}
  - {id: read, do: dmm.voltage}
outputs: {u: "${{ steps.read.voltage }}"}
"""


def load(folder, text=LAB, **files):
    for name, content in files.items():
        (folder / f"{name}.yaml").write_text(content)
    path = folder / "lab.yaml"
    path.write_text(text)
    lab, problems = load_lab(path)
    return lab, [f"{p.code} {p.line}:{p.column} {p.message}" for p in problems]


def test_the_config_is_the_contract(tmp_path):
    lab, problems = load(tmp_path)
    actions = lab.contracts["dmm@1"].actions

    assert problems == []
    assert {name: one.effect for name, one in actions.items()} == {
        "voltage": "pure", "set_range": "idempotent", "shoot": "once", "last_once": "pure",
    }  # fmt: skip
    assert actions["shoot"].probe == "last_once"
    assert actions["set_range"].required() == ["range"]
    assert actions["set_range"].sets == "range"
    assert actions["voltage"].errors["OutOfRange"].happened == "no"


def test_the_checker_knows_it_as_any_other(tmp_path):
    load(tmp_path)
    good = check_text(PROTOCOL, "p.yaml", lab=tmp_path / "lab.yaml")
    bad = check_text(PROTOCOL.replace("100 V", "1 mV"), "p.yaml", lab=tmp_path / "lab.yaml")

    assert good.problems == []
    assert [problem.code for problem in bad.problems] == ["E207"] or "0.1 V" in bad.problems[
        0
    ].message


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("unit: V}}}", "unit: Vx}}}", "E132 8:83 'Vx' is not a unit"),
        ("{range:g}", "%f", "E132 10:30 nothing that is sent has range in it: write {range}"),
        ("type: number", "type: float", "E132 8:69 'float' is not one of number, integer"),
        (
            "{voltage: {type: number, unit: V}}",
            "{dew_temp: {unit: C}}",
            "E132 8:70 'C' would be a coulomb, a charge; did you mean degC?",
        ),
        ("{range:g}", "{rnge:g}", "E132 9:28 {rnge}: the action has no parameter 'rnge'"),
        ("{range:g}", "{range:d}", "E132 9:28 {range:d}: Unknown format code 'd'"),
        ("{range:g}", "{range", "E132 9:28"),
        ("{range:g}", "{range.real}", "E132 9:28 {range.real}: the action has no parameter"),
        ("query:", "quary:", "E110 8:19 unknown key 'quary'; did you mean query?"),
        (
            "SHOT}",
            "SHOT, prompt: x}",
            "E110 11:30 unknown key 'prompt': it belongs beside `actions`",
        ),
        (
            "      errors",
            "      begin: x\n      errors",
            "E110 6:7 unknown key 'begin': it belongs into `terminator: {begin: ...}`",
        ),
        (
            "unit: V}}}",
            "unit: V, nothing: [true]}}}",
            "E132 8:95 it is a list of what stands for no value",
        ),
        (
            "      errors",
            '      prompt: "ok\\r\\nok\\r\\n"\n      errors',
            "E112 5:7 a `prompt` is one line, or the end of one",
        ),
        ("SHOT}", "SHOT, probe: last}", "E132 11:37 there is no action last"),
        ("SHOT}", "SHOT, count: set_range}", "E132 11:37 set_range is called without parameters"),
        ("SHOT}", "SHOT, effect: twice}", "E112 11:38"),
        (
            "SHOT}",
            "SHOT, timeout: 3 mm}",
            "E112 11:39 timeout: '3 mm' is not a time longer than 0 s",
        ),
        ("SHOT}", 'SHOT, answer: "("}', "E112 11:38 answer: '(' is not a regular expression"),
        ("SHOT}", "SHOT, cancel: true}", "E132 11:38 to cancel it, the instrument must be told to"),
        ("SHOT}", "SHOT, returns: {x: {}}}", "E112"),
        ("{write: SHOT}", "{}", "E112"),
        ("TCPIP::10.0.0.5::5025::SOCKET", "the dmm", "E112 5:17 resource: 'the dmm' is no address"),
        (
            "resource: TCPIP::10.0.0.5::5025::SOCKET",
            "timeout: 1 s",
            "E111 5:7 the key 'resource' is missing",
        ),
        (
            "      errors",
            "      safe_state: [off]\n      errors",
            "E132 6:20 there is no action off",
        ),
        (
            "      errors",
            "      status: [volts]\n      errors",
            "E132 6:16 there is no action volts",
        ),
        ("happened: no", "happened: perhaps", "E112 6:51"),
        ("minimum: 0.1", "minimun: 0.1", "E132 10:47 unknown key 'minimun'; did you mean minimum?"),
        ("unit: V}}}", "unit: V, scale: 0}}}", "E132 8:93 it is a number other than 0"),
        ("unit: V}}}", "unit: V, bits: [7, 4]}}}", "E132 8:92 it is the first and the last bit"),
        ("unit: V}}}", "unit: V, decimal: ;}}}", "E132 8:95 it is a point or a comma"),
        (
            "      errors",
            "      local_port: 4000\n      errors",
            "E112 5:7 a `local_port` is where answers",
        ),
        (
            "unit: V}}}",
            "unit: V}}, until: {do: voltage, poll: 1 s}}",
            "E132 8:109 voltage returns no poll; it returns voltage; `poll` is said once",
        ),
    ],
)
def test_what_is_said_wrongly_is_told_at_its_place(tmp_path, old, new, told):
    assert old in LAB
    _, problems = load(tmp_path, LAB.replace(old, new, 1))

    assert len(problems) == 1 and problems[0].startswith(told), problems


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("    config:", "    port: COM3\n    config:", "`config`: config: {port: COM3}"),
        ("    config:", "    baud: 9600\n    config:", "what its driver needs goes under `config`"),
        ("{voltage: {type: number, unit: V}}", "{voltage: V}", "write voltage: {unit: V}"),
        ("{voltage: {type: number, unit: V}}", "{voltage: int}", "write voltage: {type: integer}"),
        (
            '{query: "MEAS:VOLT:DC?", returns',
            '{query: "MEAS:VOLT:DC?", unit: V, returns',
            "returns?",
        ),
        ("{write: SHOT}", '"SYST:SHOT"', "needs keys with values, not 'SYST:SHOT' = \n"),
        ("{write: SHOT}", "{write: SHOT, until: ready}", "such as until: {do: state, busy: false}"),
        (
            "driver: scpi\n    config:",
            "driver: text\n    config:\n      prompt: '>'",
            "b: leave out its empty `answer`; the prompt ends it",
        ),
    ],
)
def test_what_people_write_instead_is_told_with_the_way_on(tmp_path, old, new, says):
    assert old in LAB
    text = LAB.replace(old, new, 1)
    if "driver: text" in text:
        text = text[: text.index("      errors")] + "      actions: {b: {send: B, answer: ''}}\n"
    path = tmp_path / "lab.yaml"
    path.write_text(text)
    _, problems = load_lab(path)

    assert says in "".join(f"{p.message} = {p.hint}\n" for p in problems)


CONTRACT = """type: meter@1
actions:
  voltage:
    effect: pure
    returns: {type: object, required: [voltage], properties: {voltage: {type: number, unit: V}}}
"""
MODBUS = """devices:
  kiln:
    driver: modbus
    config:
      resource: 10.0.0.6:502
      registers: {t: {input: 0}}
      actions:
        t: {read: t, returns: {t: {unit: degC, scale: 0.1}}}
"""
APART = """contracts: [./meter.yaml]
devices:
  dmm:
    contract: meter@1
    driver: scpi
    config:
      resource: 10.0.0.5:5025
      actions:
        voltage: {query: "MEAS:VOLT:DC?"}
"""


def test_a_contract_may_stand_apart(tmp_path):
    lab, problems = load(tmp_path, APART, meter=CONTRACT)

    assert problems == []
    assert set(lab.contracts["meter@1"].actions) == {"voltage"}

    _, problems = load(tmp_path, APART, meter=CONTRACT.replace("unit: V", "unti: V"))
    assert "voltage.returns: unknown key properties.voltage.unti; did you mean unit?" in problems[0]


def test_a_scale_that_nobody_would_read_is_told(tmp_path):
    _, problems = load(tmp_path, MODBUS)

    assert problems == [
        "E132 8:48 unknown key 'scale': it stands beside the address of its register"
    ]


def test_one_that_stands_apart_and_what_is_said_must_agree(tmp_path):
    other = APART.replace("voltage:", "volts:")
    _, problems = load(tmp_path, other, meter=CONTRACT)
    twice = APART.replace('DC?"', 'DC?", returns: {voltage: {unit: mV}}')
    _, differing = load(tmp_path, twice, meter=CONTRACT)

    assert problems == [
        "E132 8:7 voltage of meter@1 is not said here",
        "E132 9:9 meter@1 has no action volts; it has voltage; did you mean voltage?",
    ]
    assert differing[0].startswith("E132 9:43 returns of voltage differ")


def test_two_devices_may_share_what_is_said(tmp_path):
    second = LAB.replace("devices:\n", "").replace("  dmm:\n", "  dmm2:\n    contract: dmm@1\n")
    second = second.replace("10.0.0.5", "10.0.0.6")
    lab, problems = load(tmp_path, LAB + second)
    _, differing = load(tmp_path, LAB + second.replace("SHOT", "SHOT, effect: idempotent"))

    assert problems == [] and lab.lab.devices["dmm2"].contract == "dmm@1"
    assert "dmm2 and dmm are both dmm@1, but say different actions" in differing[0]


def test_the_pages_lab_is_the_same(tmp_path):
    from labrun.web.local.lab_here import lab_here

    lab, _ = load(tmp_path)
    here = lab_here(lab, tmp_path / "state")

    assert here.contracts["dmm@1"] == lab.contracts["dmm@1"]
