"""`labrun graph` as a person runs it."""

import json
from pathlib import Path

from ...command_line import labrun

EXAMPLE = Path(__file__).parents[1] / "examples" / "libs_grid_scan.yaml"
FAULTY = Path(__file__).parents[1] / "faulty" / "argument_dimension.yaml"


def test_mermaid_is_printed_and_a_file_says_its_own_format(tmp_path):
    printed = labrun(tmp_path, "graph", EXAMPLE)
    written = labrun(tmp_path, "graph", EXAMPLE, "-o", "tree.dot")

    assert printed.returncode == 0 and printed.stdout.startswith("flowchart TD\n")
    assert (written.returncode, written.stdout) == (0, "tree.dot\n")
    assert (tmp_path / "tree.dot").read_text(encoding="utf-8").startswith("digraph protocol {")


def test_a_markdown_file_holds_a_fenced_drawing(tmp_path):
    labrun(tmp_path, "graph", EXAMPLE, "-o", "tree.md")
    text = (tmp_path / "tree.md").read_text(encoding="utf-8")

    assert text.startswith("```mermaid\nflowchart TD\n") and text.endswith("```\n")


def test_a_picture_and_an_unknown_format_are_refused_with_what_to_do(tmp_path):
    picture = labrun(tmp_path, "graph", EXAMPLE, "-o", "tree.svg")
    other = labrun(tmp_path, "graph", EXAMPLE, "--format", "xml")
    nowhere = labrun(tmp_path, "graph", EXAMPLE, "-o", "no/tree.dot")

    assert picture.returncode == 2 and "dot -Tsvg tree.dot -o tree.svg" in picture.stderr
    assert other.returncode == 2 and "choose mermaid or dot" in other.stderr
    assert nowhere.returncode == 2 and "cannot be written" in nowhere.stderr


def test_problems_are_said_and_nothing_is_drawn(tmp_path):
    done = labrun(tmp_path, "graph", FAULTY)

    assert (done.returncode, done.stdout) == (2, "")
    assert "error[E204]" in done.stderr


def test_json_protocols_are_drawn_and_more_arrows_than_mermaid_draws_are_said(tmp_path):
    steps = [{"log": str(index)} for index in range(600)]
    protocol = {"labrun": 1, "name": "long", "steps": steps}
    (tmp_path / "long.json").write_text(json.dumps(protocol))
    done = labrun(tmp_path, "graph", "long.json")

    assert done.returncode == 0 and done.stdout.count(":::instantNode") == 600
    assert "Mermaid draws 500 arrows" in done.stderr
