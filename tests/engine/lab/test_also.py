"""A device of a later contract plays the roles of the earlier ones that it keeps."""

from labrun.engine.check import check_file
from labrun.engine.lab.lab import load_lab

LAB = """\
devices:
  stage:
    contract: gantry@2
    driver: sim_gantry
    config: {clock: fast, homed: true}
    limits: {x: {minimum: -300, maximum: 1000}}
"""
PROTOCOL = """\
labrun: 1
name: there
devices: {gantry: CONTRACT}
steps:
  - {do: gantry.move_to, with: {x: VALUE}}
"""


def told(folder, contract, value):
    lab = written(folder / "lab.yaml", LAB)
    text = PROTOCOL.replace("CONTRACT", contract).replace("VALUE", value)
    checked = check_file(written(folder / "protocol.yaml", text), lab=lab)
    return [problem.message for problem in checked.problems if problem.severity == "error"]


def written(path, text):
    path.write_text(text, encoding="utf-8")
    return path


def test_a_protocol_for_gantry_1_runs_on_a_gantry_2(tmp_path):
    assert told(tmp_path, "gantry@1", "700 mm") == []


def test_it_keeps_to_both_ranges_that_of_its_contract_and_that_of_the_lab(tmp_path):
    for value in ("800 mm", "-10 mm"):
        (message,) = told(tmp_path, "gantry@1", value)
        assert "0..730" in message or "0 to 730" in message


def test_a_protocol_for_gantry_2_has_the_labs_range(tmp_path):
    assert told(tmp_path, "gantry@2", "-250 mm") == []
    assert told(tmp_path, "gantry@2", "900 mm") == []
    assert len(told(tmp_path, "gantry@2", "-301 mm")) == 1


def test_a_limit_that_would_widen_gantry_1_is_told(tmp_path):
    text = LAB.replace("gantry@2", "gantry@1").replace("-300", "0")
    _, problems = load_lab(written(tmp_path / "lab.yaml", text))

    (problem,) = problems
    assert problem.severity == "warning"
    assert "goes to 730 mm, so a maximum of 1000 changes nothing" in problem.message
    assert "gantry@2" in problem.hint


def test_a_contract_that_keeps_not_what_it_says_is_refused(tmp_path):
    contract = "type: lift@1\nalso: [gantry@1]\nactions: {up: {summary: up}}\n"
    written(tmp_path / "lift.yaml", contract)
    text = "contracts: [./lift.yaml]\n" + LAB.replace("gantry@2", "gantry@1")
    _, problems = load_lab(written(tmp_path / "lab.yaml", text))

    assert any("lift@1 does not keep gantry@1: " in p.message for p in problems if p.code == "E130")
