"""Steps of which a journal says nothing, though the run has gone past them."""

from labrun.engine.check import check_text
from labrun.web.runs.outline import Outline
from labrun.web.runs.passed import passed

TEXT = """\
labrun: 1
name: quiet
params: {fine: {type: boolean, default: false}}
devices: {gantry: gantry@1, libs: libs_analyzer@1}
defaults: {timeout: 60 s}
steps:
  - {id: names, set: {n: 1}}
  - {id: extra, when: "${{ params.fine }}", do: gantry.home}
  - id: group
    when: ${{ params.fine }}
    steps: [{id: inner, do: gantry.home}]
  - id: choice
    if: ${{ params.fine }}
    then: [{id: fine, do: gantry.home}]
    else: [{id: coarse, do: gantry.move_to, with: {z: 1}}]
  - id: scan
    foreach: {i: "${{ range(3) }}"}
    steps:
      - {id: first, do: gantry.move_to, with: {x: 1}}
      - {id: sometimes, when: "${{ i == 9 }}", do: libs.measure}
      - {id: check, require: "${{ i < 9 }}"}
  - {id: end, do: gantry.move_to, with: {x: 0}}
on_resume: [{do: gantry.home}]
"""


def behind(*begun, rounds=(), over=False):
    checked = check_text(TEXT, "quiet.yaml")
    assert checked.ok, checked.problems
    paths = {f"main/{path}" for path in begun}
    found = passed(Outline(checked), paths, {f"main/{r}" for r in rounds}.__contains__, over)
    return {path.removeprefix("main/"): status for path, status in found.items()}


def test_before_anything_has_begun_nothing_is_behind():
    assert behind() == {}


def test_what_stands_before_a_step_that_has_begun_was_skipped_or_only_computed():
    assert behind("choice", "choice/else/coarse") == {
        "names": "ok", "extra": "skipped", "group": "skipped", "group/inner": "skipped",
    }  # fmt: skip


def test_the_branch_that_was_not_taken_is_skipped_when_the_choice_is_behind():
    found = behind("choice", "choice/else/coarse", "scan", "scan/*/first")

    assert found["choice/then/fine"] == "skipped"
    assert not {"scan/*/sometimes", "scan/*/check", "end"} & set(found)


def test_in_a_loop_an_iteration_that_succeeded_has_gone_past_all_its_steps():
    found = behind("scan", "scan/*/first", rounds=["scan"])

    assert found["scan/*/sometimes"] == "skipped" and found["scan/*/check"] == "ok"
    assert "end" not in found


def test_a_run_that_succeeded_has_left_nothing_waiting():
    found = behind("scan", "scan/*/first", over=True)

    assert found["end"] == "skipped" and found["choice"] == "skipped"
    assert not any(path.startswith("resume/") for path in found)
