"""`labrun explain` counts the actions of a protocol and numbers its sets."""

import json
from pathlib import Path

import pytest

from labrun.engine.check import check_file, check_text
from labrun.engine.views.explain import explain_protocol

EXAMPLE = Path(__file__).parents[1] / "examples" / "libs_grid_scan.yaml"
HEADER = """\
labrun: 1
name: t
params: {n: {type: integer, default: 3}}
devices: {gantry: gantry@1, libs: libs_analyzer@1}
steps:
  - {id: shoot, do: libs.measure, timeout: 15 s}
"""


def lines(steps: str) -> list[str]:
    checked = check_text(HEADER + steps, "t.yaml")
    assert checked.ok, checked.problems
    return list(explain_protocol(checked))


def head(steps: str) -> str:
    return next(line for line in lines(steps) if line.startswith("P ="))


def test_the_example_is_explained_with_sizes_and_counts():
    said = list(explain_protocol(check_file(EXAMPLE)))
    text = "\n".join(said)

    assert "P = [A1, ..., A7]: 6,428 actions, if nothing fails" in said
    assert "A1 = {gantry.home, libs.locate}" in text and "|A1| = 2" in text
    assert "a grid of 21 x 51 = 1,071 points (snake)" in text
    assert "in the background" in text
    assert 'if it still fails (1): "wake the analyser' in text


def test_the_worst_case_is_said_beside_the_count():
    said = list(explain_protocol(check_file(EXAMPLE)))
    worst = 2 + 1071 * (1 + 3 + 1 + 3 + 2 + 5 + 1)

    assert f"{worst:,} with every retry and fallback" in said[6]
    assert "more if a person chooses `repeat`" in said[6]


def test_a_loop_of_unknown_length_is_said_to_be_so():
    steps = """\
  - foreach: {letter: "${{ [steps.shoot.shot_id] }}"}
    steps:
      - do: gantry.home
"""

    assert head(steps) == "P = [A1, ..., A2]: 1 + 1 for each letter actions, if nothing fails"
    assert any("? ×" in line for line in lines(steps))


HOME, PAIR = "{do: gantry.home}", "{steps: [{do: libs.locate}, {do: libs.disarm}]}"
TWO_OR_ONE = f"then: [{HOME}, {HOME}], else: [{HOME}]"
EACH = '{foreach: {i: "${{ range(params.n) }}"}, steps: ['
UNKNOWN = "\"${{ steps.shoot.shot_id == 'a' }}\""


@pytest.mark.parametrize(
    ("step", "count"),
    [
        (f"{{repeat: 4, steps: [{HOME}]}}", "5"),
        (f"{{while: {UNKNOWN}, max: 10, steps: [{HOME}]}}", "1 to 11"),
        (f"{{any: [{HOME}, {{do: libs.locate}}]}}", "3"),
        (f"{{any: [{HOME}, {PAIR}]}}", "2 to 4"),
        (f"{{parallel: [{HOME}, {PAIR}]}}", "4"),
        (f"{{if: {UNKNOWN}, {TWO_OR_ONE}}}", "2 to 3"),
        (f'{{if: "${{{{ params.n > 2 }}}}", {TWO_OR_ONE}}}', "3"),
        ('{when: "${{ run.simulated }}", do: gantry.home}', "1 to 2"),
        ('{when: "${{ params.n == 3 }}", do: gantry.home}', "2"),
        (f'{EACH} {{foreach: {{j: "${{{{ range(i) }}}}"}}, steps: [{HOME}]}}]}}', "4"),
        (f'{EACH} {{if: "${{{{ i > 0 }}}}", then: [{HOME}]}}]}}', "3"),
    ],
)
def test_actions_are_counted_through_every_kind_of_step(step, count):
    assert f": {count} actions" in head(f"  - {step}\n")


def test_retries_of_groups_and_of_their_members_multiply():
    said = lines("  - {retry: 2, steps: [{do: gantry.home, retry: 3}, {do: libs.locate}]}\n")

    assert any(line.strip() == "9 at most, with every retry and fallback" for line in said)


def test_members_that_are_whole_sequences_show_their_own_sets():
    said = lines(
        "  - parallel:\n"
        "      - {steps: [{repeat: 2, steps: [{do: gantry.home}]}]}\n"
        "      - {do: libs.locate}\n"
    )

    assert "  at the same time, 2 members" in said
    assert any("A2 = {gantry.home}" in line and "2 ×" in line for line in said)


def test_a_protocol_that_is_used_is_counted_and_shown_with_its_finally(tmp_path):
    inner = {
        "labrun": 1, "name": "inner", "params": {"n": {"type": "integer", "default": 1}},
        "devices": {"libs": "libs_analyzer@1"},
        "steps": [{"repeat": "${{ params.n }}", "steps": [{"do": "libs.locate"}]}],
        "finally": [{"do": "libs.disarm"}],
    }  # fmt: skip
    outer = {
        "labrun": 1, "name": "outer", "devices": {"libs": "libs_analyzer@1"},
        "steps": [{"foreach": {"k": [2, 3]}, "steps": [{"use": "inner.json", "with": {"n": "${{ k }}"}}]}],
    }  # fmt: skip
    for protocol in (inner, outer):
        (tmp_path / f"{protocol['name']}.json").write_text(json.dumps(protocol))
    said = list(explain_protocol(check_file(tmp_path / "outer.json")))

    assert "P = [A1, ..., A2]: 7 actions, if nothing fails" in said
    assert any("use inner.json: inner" in line for line in said)
    assert any("A1 = {libs.locate}" in line and "5 ×" in line for line in said)
    assert any("A2 = {libs.disarm}" in line and "2 ×" in line for line in said)


def test_what_is_open_in_each_of_many_iterations_is_said_once():
    told = "\n".join(
        explain_protocol(
            check_text(
                """labrun: 1
name: t
devices: {gantry: gantry@1}
steps:
  - set: {z: 0}
  - foreach: {i: "${{ range(28) }}"}
    steps:
      - if: "${{ z < i }}"
        then:
          - foreach: {at: "${{ range(z) }}"}
            steps: [{do: gantry.move_to, with: {z: "${{ at }}"}}]
          - set: {z: "${{ z + 1 }}"}
""",
                "t.yaml",
            )
        )
    )

    assert "28 × (1 for each at) actions" in told
