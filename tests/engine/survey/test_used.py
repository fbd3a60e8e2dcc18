"""`use`: another protocol is opened, checked with its arguments, and rejected where it cannot be."""

import pytest

from labrun.engine.check import check_file

INNER = """labrun: 1
name: inner
params:
  x: {type: quantity, unit: mm}
  n: {type: integer, default: 1, minimum: 1, maximum: 5}
devices: {gantry: gantry@1}
steps:
  - {do: gantry.move_to, with: {x: "${{ params.x }}"}}
  - {log: "${{ params.n }}"}
outputs: {where: "${{ params.x }}"}
"""


def problems(tmp_path, steps, inner=INNER, devices="{gantry: gantry@1}"):
    (tmp_path / "inner.yaml").write_text(inner)
    (tmp_path / "outer.yaml").write_text(
        f"labrun: 1\nname: outer\ndevices: {devices}\nsteps:\n{steps}"
    )
    found = check_file(tmp_path / "outer.yaml", needed=True).problems
    errors = [p for p in found if p.severity == "error"]
    return [(p.file.rpartition("/")[2], p.line, p.code) for p in errors]


def test_a_protocol_that_is_used_as_it_declares_has_no_problem(tmp_path):
    steps = '  - {id: u, use: ./inner.yaml, with: {x: 3 mm}}\n  - {log: "${{ steps.u.where + 1 mm }}"}\n'

    assert problems(tmp_path, steps) == []


@pytest.mark.parametrize("named", ["../shared/inner.yaml", "{shared}/inner.yaml", "link.yaml"])
def test_a_file_outside_the_protocol_s_folder_is_used_only_if_the_lab_lists_its_folder(
    tmp_path, named
):
    shared, own = tmp_path / "shared", tmp_path / "own"
    shared.mkdir()
    own.mkdir()
    (shared / "inner.yaml").write_text(INNER)
    (shared / "t.csv").write_text("x (mm)\n1\n")
    (own / "link.yaml").symlink_to(shared / "inner.yaml")
    (own / "outer.yaml").write_text(
        "labrun: 1\nname: outer\ndevices: {gantry: gantry@1}\nsteps:\n"
        f"  - {{use: {named.format(shared=shared)}, with: {{x: 3 mm}}}}\n"
        "  - foreach: {row: \"${{ csv('../shared/t.csv') }}\"}\n"
        "    steps: [{log: '${{ row.x }}'}]\n"
    )
    lab = tmp_path / "lab.yaml"
    found = {}
    for folders in ("[]", "[shared]"):
        lab.write_text(
            f"folders: {folders}\ndevices: {{gantry: {{contract: gantry@1, driver: sim_gantry}}}}\n"
        )
        problems = check_file(own / "outer.yaml", lab=lab, needed=True).problems
        found[folders] = [
            (p.code, "`folders:`" in p.message) for p in problems if p.severity == "error"
        ]

    assert found == {"[]": [("E120", True), ("E313", True)], "[shared]": []}


@pytest.mark.parametrize(
    ("steps", "expected"),
    [
        ("  - {use: ./inner.yaml}\n", [("outer.yaml", 5, "E232")]),
        ("  - {use: ./inner.yaml, with: {x: 3 mm, m: 2}}\n", [("outer.yaml", 5, "E231")]),
        ("  - {use: ./inner.yaml, with: {x: 3 s}}\n", [("outer.yaml", 5, "E233")]),
        ("  - {use: ./inner.yaml, with: {x: 3 mm, n: 9}}\n", [("outer.yaml", 5, "E233")]),
        ("  - {use: ./innre.yaml}\n", [("outer.yaml", 5, "E120")]),
        ("  - {use: .}\n", [("outer.yaml", 5, "E120")]),
        ('  - {use: "${{ 1 }}.yaml"}\n', [("outer.yaml", 5, "E120")]),
        ("  - {use: ./outer.yaml}\n", [("outer.yaml", 5, "E121")]),
        (
            "  - {use: ./inner.yaml, with: {x: 3 mm}, devices: {gantri: gantry}}\n",
            [("outer.yaml", 5, "E230")],
        ),
        (
            "  - {use: ./inner.yaml, with: {x: 3 mm}, devices: {gantry: gantri}}\n",
            [("outer.yaml", 5, "E230")],
        ),
        (
            '  - {id: u, use: ./inner.yaml, with: {x: 3 mm}}\n  - {log: "${{ steps.u.were }}"}\n',
            [("outer.yaml", 6, "E301")],
        ),
        (
            '  - foreach: {i: "${{ range(8) }}"}\n    steps:\n'
            '      - {use: ./inner.yaml, with: {x: 3 mm, n: "${{ i + 1 }}"}}\n',
            [("outer.yaml", 7, "E233")],
        ),
    ],
)
def test_what_a_used_protocol_does_not_take_is_said_where_it_is_given(tmp_path, steps, expected):
    assert problems(tmp_path, steps) == expected


def test_a_value_that_leaves_the_bench_is_found_in_the_used_protocol(tmp_path):
    steps = "  - {use: ./inner.yaml, with: {x: 3 m}}\n"

    assert problems(tmp_path, steps) == [("inner.yaml", 8, "E207")]


def test_a_role_that_is_not_here_is_missed_at_the_use(tmp_path):
    steps = "  - {use: ./inner.yaml, with: {x: 3 mm}}\n  - {do: b.move_to, with: {x: 1}}\n"

    assert problems(tmp_path, steps, devices="{b: gantry@1}") == [("outer.yaml", 5, "E230")]
    mapped = "  - {use: ./inner.yaml, with: {x: 3 mm}, devices: {gantry: b}}\n"
    assert problems(tmp_path, mapped, devices="{b: gantry@1}") == []


def test_protocols_that_use_each_other_are_refused_with_the_way(tmp_path):
    inner = "labrun: 1\nname: inner\nsteps: [{use: ./outer.yaml}]\n"
    (tmp_path / "inner.yaml").write_text(inner)
    (tmp_path / "outer.yaml").write_text("labrun: 1\nname: outer\nsteps: [{use: ./inner.yaml}]\n")
    (problem,) = check_file(tmp_path / "outer.yaml").problems

    assert problem.code == "E121"
    assert problem.message == "outer.yaml uses inner.yaml uses outer.yaml"
    assert problem.file.endswith("inner.yaml")


def test_a_fault_in_a_used_protocol_is_told_once_however_often_it_is_used(tmp_path):
    inner = INNER.replace("gantry.move_to", "gantry.mvoe_to")
    steps = "  - {use: ./inner.yaml, with: {x: 3 mm}}\n" * 3

    assert problems(tmp_path, steps, inner) == [("inner.yaml", 8, "E202")]
