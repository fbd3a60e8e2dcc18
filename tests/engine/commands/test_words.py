"""`labrun words` as a person runs it."""

import json
from pathlib import Path

from ...command_line import labrun

EXAMPLE = Path(__file__).parents[1] / "examples" / "libs_grid_scan.yaml"


def test_parameters_of_the_command_line_are_in_the_sentences(tmp_path):
    done = labrun(tmp_path, "words", EXAMPLE, "-p", "pitch=1 mm", "-p", "sample=SPD-07")

    assert done.returncode == 0
    assert "At each of 55 points of a 5 x 11 grid" in done.stdout and "SPD-07" in done.stdout


def test_markdown_is_asked_for_by_format_and_another_is_refused(tmp_path):
    done = labrun(tmp_path, "words", EXAMPLE, "--format", "markdown")
    other = labrun(tmp_path, "words", EXAMPLE, "--format", "latex")

    assert done.returncode == 0 and done.stdout.startswith("# libs-grid-scan\n")
    assert other.returncode == 2 and "choose text or markdown" in other.stderr


def test_json_protocols_are_said_as_well(tmp_path):
    protocol = {"labrun": 1, "name": "short", "steps": [{"wait": "2 s"}]}
    (tmp_path / "short.json").write_text(json.dumps(protocol))
    done = labrun(tmp_path, "words", "short.json")

    assert done.returncode == 0 and "1. The protocol waits 2 s." in done.stdout
