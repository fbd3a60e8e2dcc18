"""`labrun schema` as a person runs it."""

import json

from ...command_line import labrun


def test_it_is_written_to_standard_output_or_to_a_file_with_the_line_to_begin_with(tmp_path):
    shown = labrun(tmp_path, "schema")
    written = labrun(tmp_path, "schema", "-o", ".labrun/protocol.schema.json")
    text = (tmp_path / ".labrun" / "protocol.schema.json").read_text(encoding="utf-8")

    assert (shown.returncode, shown.stderr) == (0, "")
    assert json.loads(shown.stdout)["$schema"].endswith("2020-12/schema")
    assert written.returncode == 0 and written.stdout == "" and text == shown.stdout
    assert "# yaml-language-server: $schema=./.labrun/protocol.schema.json" in written.stderr


def test_a_lab_that_is_not_in_order_is_told_and_nothing_is_written(tmp_path):
    (tmp_path / "lab.yaml").write_text("devices: {a: {contract: gantri@1, driver: sim_gantry}}\n")
    done = labrun(tmp_path, "schema", "--lab", "lab.yaml", "-o", "made.json")

    assert (done.returncode, done.stdout) == (2, "")
    assert "there is no contract gantri@1" in done.stderr
    assert not (tmp_path / "made.json").exists()


def test_a_file_that_cannot_be_written_is_said_in_one_sentence(tmp_path):
    done = labrun(tmp_path, "schema", "-o", tmp_path)

    assert done.returncode == 2
    assert "cannot be written" in done.stderr and "Traceback" not in done.stderr
