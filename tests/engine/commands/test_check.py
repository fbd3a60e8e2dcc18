"""`labrun check` as a person runs it."""

import json
import subprocess
from pathlib import Path

from ...command_line import labrun

HERE = Path(__file__).parents[1]
EXAMPLE = HERE / "examples" / "libs_grid_scan.yaml"
FAULTY = HERE / "faulty" / "argument_dimension.yaml"


def check(*words: object) -> subprocess.CompletedProcess[str]:
    return labrun(Path(), "check", *words)


def test_a_protocol_in_order_is_0_and_a_faulty_one_is_2():
    fine, faulty = check(EXAMPLE), check(FAULTY)

    assert (fine.returncode, fine.stderr) == (0, "")
    assert "no problems" in fine.stdout
    assert faulty.returncode == 2
    assert "error[E204]" in faulty.stdout and "1 error. Nothing was sent" in faulty.stdout


def test_options_that_change_nothing_change_nothing(tmp_path):
    # Without options nothing reads them: the same words and status by another way.
    files = (FAULTY, EXAMPLE, tmp_path / "none.yaml")
    plainly, with_options = check(*files), check(*files, "--format", "text")

    assert plainly.returncode == with_options.returncode == 2
    assert (plainly.stdout, plainly.stderr) == (with_options.stdout, with_options.stderr)
    assert "error[E204]" in plainly.stdout and "error[E100]" in plainly.stdout


def test_several_files_and_options_are_one_list_in_json():
    done = check(EXAMPLE, FAULTY, "--format", "json", "-p", "pith=1 mm", "--bind", "libs=gantry")
    found = {(p["file"], p["code"]) for p in json.loads(done.stdout)}

    assert done.returncode == 2
    assert {("-p", "E220"), ("--bind", "E210"), (str(FAULTY), "E204")} <= found


def test_what_cannot_be_a_protocol_is_a_problem_not_a_traceback(tmp_path):
    for path in (tmp_path, tmp_path / "none.yaml"):
        done = check(path)

        assert done.returncode == 2
        assert "error[E100]" in done.stdout and "Traceback" not in done.stderr


def test_explain_prints_the_sets():
    done = labrun(Path(), "explain", EXAMPLE)

    assert done.returncode == 0
    assert "P = [A1, ..., A7]" in done.stdout
