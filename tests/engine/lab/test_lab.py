"""Labs are read with their contracts and limits, and problems are reported at their places."""

import json
from pathlib import Path

import pytest

from labrun.drivers.find import SHIPPED
from labrun.engine.lab.lab import CONFIGLESS, load_lab
from labrun.schemas.contracts import shipped_contracts

LAB = """\
name: cellar
contracts: [./furnace.yaml]
devices:
  oven: {contract: oven@1, url: "http://10.0.0.7:4101", limits: {target: {maximum: 900 degC}}}
  gantry: {contract: gantry@1, driver: sim_gantry, limits: {x: {maximum: 40 cm}}}
"""
FURNACE = """\
type: oven@1
actions:
  heat:
    params: {properties: {target: {type: number, unit: degC, maximum: 1200}}}
"""


def write(folder: Path, lab: str = LAB, furnace: str = FURNACE) -> Path:
    (folder / "furnace.yaml").write_text(furnace)
    path = folder / "lab.yaml"
    path.write_text(lab)
    return path


def told(path: Path) -> list[str]:
    return [f"{p.code} {p.line}:{p.column}" for p in load_lab(path)[1]]


def test_without_a_file_the_simulated_lab_is_used():
    lab, problems = load_lab(None)

    assert problems == []
    assert lab is not None and lab.lab.simulated and lab.path is None
    assert lab.contracts[lab.lab.devices["gantry"].contract].actions


def test_a_lab_brings_its_own_contracts_and_limits(tmp_path):
    lab, problems = load_lab(write(tmp_path))

    assert problems == []
    assert lab is not None and "heat" in lab.contracts["oven@1"].actions
    assert lab.lab.devices["gantry"].limits["x"].maximum == "40 cm"


def test_what_is_wrong_in_a_lab_is_told_at_its_place(tmp_path):
    assert told(write(tmp_path, LAB.replace("gantry@1", "gantri@1"))) == ["E130 5:22"]
    assert told(write(tmp_path, LAB.replace("x: {max", "xx: {max"))) == ["E131 5:61"]
    assert told(write(tmp_path, LAB.replace("40 cm", "40 s"))) == ["E131 5:74"]
    assert told(write(tmp_path, LAB.replace("driver", "drivr"))) == ["E110 5:32"]
    with_config = LAB.replace("sim_gantry", "sim_gantry, config: {clock: fast, sede: 3}")
    assert told(write(tmp_path, with_config)) == ["E132 5:74"]
    for within, key in (("axes: {x: Y, yy: X}", "yy"), ("keep_out: [{x: [0, 1]}, {q: 2}]", "q")):
        with_config = LAB.replace("sim_gantry", f"grbl, config: {{port: x, {within}}}")
        line = with_config.splitlines()[4]
        assert told(write(tmp_path, with_config)) == [f"E132 5:{line.index(f'{key}: ') + 1}"]
    for driver, config, value in (
        ("grbl", "port: x, baud: fast", "fast"), ("grbl", "port: x, keep_out: [{x: [5, 1]}]", "[5, 1]"),
        ("grbl", "port: x, outputs: {laser: on}", "on}"), ("balance", "port: x, parity: even", "even"),
        ("zaber", "port: x, stages: {x: {device: 0}}", "0}}"), ("aecp", "exports: x, clock_s: y", "y}"),
        ("sim_gantry", "clock: quick, seed: 1", "quick"), ("oak", "size: [640]", "[640]"),
        ("marlin", "port: x, keep_out: {x: [1, 5]}", "{x: [1"),
        ("grbl", "baud: 9600", "{baud"), ("aecp", "clock_s: 1", "{clock_s"),
        ("scpi", "timeout: 1 s", "{timeout"),
    ):  # fmt: skip
        with_config = LAB.replace("sim_gantry", f"{driver}, config: {{{config}}}")
        line = with_config.splitlines()[4]
        assert told(write(tmp_path, with_config)) == [f"E132 5:{line.index(value) + 1}"]
    assert told(write(tmp_path, LAB.replace("furnace.yaml", "none.yaml"))) == ["E130 2:13"]
    other = LAB.replace("sim_gantry", "sim_balance, config: {clock: fast}")
    assert told(write(tmp_path, other)) == ["E132 5:22"]
    assert told(tmp_path / "nowhere.yaml") == ["E100 1:1"]


@pytest.mark.slow
def test_every_driver_without_a_config_is_told_what_it_lacks_unless_it_needs_none(tmp_path):
    drivers = [driver for driver in SHIPPED if not driver.startswith("sim_")]
    found = {}
    for driver in drivers:
        (tmp_path / "bare.yaml").write_text(
            f"devices: {{a: {{contract: gantry@1, driver: {driver}}}}}"
        )
        found[driver] = told(tmp_path / "bare.yaml")

    assert {driver for driver, problems in found.items() if problems == []} == CONFIGLESS
    assert {problem[:4] for problems in found.values() for problem in problems} == {"E132"}


@pytest.mark.parametrize(
    ("right", "wrong", "place"),
    [
        ("degC", "degX", "E130 4:56"), ("degC", "C", "E130 4:56"), ("maximum", "maximun", "E130 4:71"),
        ("oven@1", "oven", "E112 1:7"), ("heat:", "heat:\n    effekt: once", "E110 4:5"),
        ("  heat", "\theat", "E101 3:1"), (FURNACE, "", "E100 1:1"),
        ("heat:", "heat:\n    duration: 5 mm", "E112 4:15"), ("heat:", "heat:\n    probe: look", "E130 4:12"),
        ("actions", "safe_state: [of]\nactions", "E130 2:14"),
        ("maximum", "minimum: 1300, maximum", "E130 4:71"), ("maximum", "default: hot, maximum", "E130 4:71"),
        ("heat:", "heat:\n    probe: heat", "E130 4:12"), ("heat:", "heat:\n    takes: x", "E112 4:12"),
        ("actions", "status: {properties: {t: {type: float}}}\nactions", "E130 2:33"),
        (
            "actions:\n  heat:\n    params: {",
            "safe_state: [heat]\nactions:\n  heat:\n    params: {required: [target], ", "E130 2:14",
        ),
        (FURNACE, "labrun: 1\nsteps: []", "E113 1:1"),
        ("properties:", "required: [tgt], properties:", "E130 4:25"), ("number", "float", "E130 4:42"),
    ],
)  # fmt: skip
def test_what_is_wrong_in_a_contract_is_told_at_its_place_there(tmp_path, right, wrong, place):
    path = write(tmp_path, furnace=FURNACE.replace(right, wrong))
    (problem,) = load_lab(path)[1]

    assert f"{problem.code} {problem.line}:{problem.column}" == place
    assert problem.file == str(tmp_path / "furnace.yaml")


def test_a_contract_in_the_place_of_one_that_ships_is_told_and_a_copy_of_it_is_not(tmp_path):
    path = write(tmp_path, furnace=FURNACE.replace("oven@1", "furnace@1"))
    path.write_text(LAB.replace("oven@1", "furnace@1"))
    (problem,) = load_lab(path)[1]

    assert (problem.code, problem.severity, problem.line) == ("E130", "warning", 2)

    shipped = shipped_contracts()["furnace@1"].model_dump(mode="json", exclude_none=True)
    (tmp_path / "furnace.yaml").write_text(json.dumps(shipped))
    limits = ", limits: {target: {maximum: 900 degC}}"
    path.write_text(LAB.replace("oven@1", "furnace@1").replace(limits, ""))

    assert load_lab(path)[1] == []


def test_a_check_leaves_no_file_where_it_was_called(tmp_path, monkeypatch):
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    config = "sim_gantry, config: {clock: fast}"

    assert told(write(tmp_path, LAB.replace("sim_gantry", config))) == []
    assert list(here.iterdir()) == []


@pytest.mark.parametrize(("value", "seconds"), [("2 min", 120.0), ("90 s", 90.0), (5, 5.0)])
def test_a_lab_says_how_long_its_servers_may_take_to_start(tmp_path, value, seconds):
    path = tmp_path / "lab.yaml"
    path.write_text(
        f"name: l\nstart_timeout: {value}\ndevices: {{g: {{contract: gantry@1, driver: sim_gantry}}}}\n"
    )
    lab, problems = load_lab(path)

    assert problems == []
    assert lab.lab.start_timeout_s == seconds


@pytest.mark.parametrize("value", ["0 s", "5 mm", "soon"])
def test_a_start_timeout_that_is_not_a_time_is_a_problem(tmp_path, value):
    path = tmp_path / "lab.yaml"
    path.write_text(
        f"name: l\nstart_timeout: {value}\ndevices: {{g: {{contract: gantry@1, driver: sim_gantry}}}}\n"
    )
    _, problems = load_lab(path)

    assert [(p.line, p.severity) for p in problems] == [(2, "error")]


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        ("devices: {g: {contract: gantry@1, driver: sim_gantri}}", "W130", "did you mean sim_gantry?"),
        ("devices: {g: gantry@1}", "E112", "such as g: {contract: gantry@1,"),
        ("devices: {g: {contract: gantry@1}}", "E112", "give either `driver`"),
        ("devices:\n  g:\n  contract: gantry@1\n  driver: sim_gantry", "E112", "indent what belongs"),
        ("devices: [g]", "E112", "such as devices: {gantry: {contract: gantry@1"),
        ("labrun: 1\ndevices: {g: gantry@1}\nsteps: [{do: g.home}]", "E113", "a protocol, not a lab"),
        ("devices: {g: {contract: gantry@1, driver: ./no.py:X}}", "W130", "there is no file ./no.py"),
        ("devices: {g: {contract: gantry@1, driver: grbl, port: '4101'}}", "E112", "write 4101"),
        ("name: x", "E111", "such as devices: {gantry: {contract: gantry@1"),
        (
            "notify: {to: ['a:b'], quiet_to: 7:00}\ndevices: {g: {contract: gantry@1, driver: sim_gantry}}",
            "E112", "'7:00' is not a time of day such as 07:00",
        ),
        (
            "devices: {g: {contract: gantry@1, driver: sim_gantry, limits: {x: {minimum: 9, maximum: 5}}}}",
            "E131", "the minimum 9 is above the maximum 5",
        ),
        (
            "devices:\n  g: {contract: gantry@1, driver: sim_gantry, port: 4101}\n"
            "  h: {contract: gantry@1, driver: sim_gantry, port: 4101}",
            "E112", "port 4101 is already that of g",
        ),
        (
            "devices:\n  g: {contract: gantry@1, driver: grbl, config: {port: COM3}}\n"
            "  h: {contract: gantry@1, driver: marlin, config: {port: com3}}",
            "W131", "h is at com3, as g is",
        ),
        (
            "folders: [., ./tabels]\ndevices: {g: {contract: gantry@1, driver: sim_gantry}}",
            "W133", "there is no folder ./tabels",
        ),
        (
            "devices: {g: {contract: gantry@1, driver: grbl, start_timeout: 2 min}}",
            "E110", "it belongs to the lab, not to one devicewrite `start_timeout` in the first column",
        ),
        (
            "devices: {g: {contract: gantry@1, url: 'http://10.0.0.7:65536'}}",
            "E112", "url: http://10.0.0.7:65536 is no address: a port is a number",
        ),
        (
            "devices: {m: {driver: text, config: {resource: COM3, terminator: {read: ''},\n"
            "  actions: {v: {send: V}}}}}",
            "E112", "read: it is an empty text",
        ),
        ("devices: {~: {}, g: {contract: gantry@1, driver: sim_gantry}}", "E103", "not `~`, which is null"),
    ],
)  # fmt: skip
def test_a_mistake_in_a_lab_is_told_once_with_the_way_on(tmp_path, text, code, words):
    path = tmp_path / "lab.yaml"
    path.write_text(f"{text}\n")
    (problem,) = load_lab(path)[1]

    assert problem.code == code
    assert words in problem.message + problem.hint


def test_only_what_cannot_be_shared_is_told(tmp_path):
    path = tmp_path / "lab.yaml"
    lines = ["devices:"]
    for name, driver, place in (
        ("a", "text", "resource: 10.0.0.5:5025"), ("b", "scpi", "resource: TCPIP::10.0.0.5::5025::SOCKET"),
        ("c", "text", "resource: /dev/x, shared: true"), ("d", "text", "resource: /dev/x, shared: true"),
        ("e", "text", "resource: /dev/x"), ("f", "text", "resource: udp://10.0.0.5:5025"),
        ("g", "modbus", "resource: 10.0.0.5:502"), ("h", "modbus", "resource: 10.0.0.5:502, unit: 2"),
        ("i", "sim_text", "resource: 10.0.0.5:5025"), ("j", "http", 'url: "http://10.0.0.5:5025"'),
    ):  # fmt: skip
        lines.append(f"  {name}: {{contract: balance@1, driver: {driver}, config: {{{place}}}}}")
    path.write_text("\n".join(lines))
    found = [(p.line, p.message) for p in load_lab(path)[1] if p.code == "W131"]

    assert found == [
        (3, "b is at TCPIP::10.0.0.5::5025::SOCKET, as a is"), (6, "e is at /dev/x, as c is"),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("interlock", "words"),
    [
        ("{door: closed}", None),
        ("{dor: closed}", "heat.interlock: the status has no dor; did you mean door?; it has door"),
        ("{door: shut}", "heat.interlock.door never holds: 'shut' is not one of"),
    ],
)
def test_an_interlock_that_the_status_can_never_meet_is_told(tmp_path, interlock, words):
    furnace = FURNACE.replace("    params", f"    interlock: {interlock}\n    params")
    status = "status: {properties: {door: {enum: [open, closed]}}}\n"
    _, problems = load_lab(write(tmp_path, furnace=furnace + status))

    if words is None:
        assert problems == []
    else:
        assert words in problems[0].message
