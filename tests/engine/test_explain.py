"""`labrun explain` counts the actions of a protocol and numbers its sets."""

from pathlib import Path

from labrun.engine.check import check_file, check_text
from labrun.engine.explain import explain_protocol

EXAMPLE = Path(__file__).parent / "examples" / "libs_grid_scan.yaml"


def test_the_example_is_explained_with_sizes_and_counts():
    lines = list(explain_protocol(check_file(EXAMPLE)))
    text = "\n".join(lines)

    assert "P = [A1, ..., A7]: 6,428 actions, if nothing fails" in lines
    assert "A1 = {gantry.home, libs.locate}" in text and "|A1| = 2" in text
    assert "a grid of 21 x 51 = 1,071 points (snake)" in text
    assert "in the background" in text


def test_a_loop_of_unknown_length_is_said_to_be_so():
    text = """\
labrun: 1
name: t
devices: {gantry: gantry@1, libs: libs_analyzer@1}
steps:
  - {id: shoot, do: libs.measure}
  - foreach: {letter: "${{ [steps.shoot.shot_id] }}"}
    steps:
      - do: gantry.home
"""
    lines = list(explain_protocol(check_text(text, "t.yaml")))

    assert "P = [A1, ..., A2]: 1 + 1 for each letter actions, if nothing fails" in lines
