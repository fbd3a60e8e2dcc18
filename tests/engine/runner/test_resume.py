"""Kill -9 at any record of the journal, resume, and check what the device really did."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from labrun.engine.journal.journal import read_records

from ...ctrl_c import TO_ONE

PROTOCOL = """labrun: 1
name: killed
devices: {a: scripted@1, b: scripted@1}
steps:
  - {id: begin, do: a.act, with: {name: begin}}
  - id: scan
    foreach: {i: "${{ range(4) }}"}
    steps:
      - {id: lower, do: a.act, with: {name: "lower${{ i }}"}}
      - {id: shoot, do: a.shoot, with: {name: "shot${{ i }}", seconds: 0.05}}
      - {id: keep, do: b.act, with: {name: "keep${{ i }}", script: "Broken,ok"}, retry: 3}
      - {id: look, do: b.act, with: {name: "look${{ i }}"}, mode: background}
    collect: {i: "${{ i }}", shot: "${{ steps.shoot.name }}", look: "${{ steps.look.name }}"}
  - {id: end, do: a.shoot, with: {name: end}}
finally:
  - {do: b.act, with: {name: tidy}}
outputs: {n: "${{ steps.scan.succeeded }}"}
"""
COMMAND = [sys.executable, "-m", "labrun.engine"]


def begin(tmp_path, lab, text=PROTOCOL):
    path = tmp_path / "killed.yaml"
    path.write_text(text, encoding="utf-8")
    return subprocess.Popen(
        [*COMMAND, "run", str(path), "--lab", str(lab), "--runs", str(tmp_path / "runs")],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip


def resume(tmp_path, *more):
    return subprocess.run(
        [*COMMAND, "resume", "last", "--runs", str(tmp_path / "runs"), *more],
        capture_output=True, text=True,
    )  # fmt: skip


def journal_of(tmp_path):
    found = list((tmp_path / "runs").glob("*/journal.jsonl"))
    return found[0] if found else None


def wait_for_records(process, tmp_path, count):
    until = time.monotonic() + 500
    while time.monotonic() < until and process.poll() is None:
        path = journal_of(tmp_path)
        if path is not None and path.read_bytes().count(b"\n") >= count:
            return
        time.sleep(0.002)


def done(bench, run, action):
    return [c["name"] for c in bench.calls(run) if c["action"] == action and c["word"] == "done"]


@pytest.mark.parametrize("records", [2, pytest.param(14, marks=pytest.mark.soak), 33])
def test_after_a_kill_every_shot_was_fired_once_and_every_row_is_there(tmp_path, bench, records):
    process = begin(tmp_path, bench.lab)
    wait_for_records(process, tmp_path, records)
    process.send_signal(signal.SIGKILL)
    process.communicate()

    went_on = resume(tmp_path)

    folder = journal_of(tmp_path).parent
    shots = done(bench, folder.name, "shoot")
    assert went_on.returncode == 0, went_on.stdout + went_on.stderr
    assert sorted(shots) == ["end", "shot0", "shot1", "shot2", "shot3"]
    rows = (folder / "data.csv").read_text().splitlines()
    assert rows == [
        "key,i,shot,look,fate",
        *(f"{i},{i},shot{i},look{i},succeeded" for i in range(4)),
    ]
    assert list(read_records(folder / "journal.jsonl"))[-1].outputs == {"n": 4}


@pytest.mark.soak
def test_a_run_that_was_killed_many_times_still_ends_with_every_shot_once(tmp_path, bench):
    process = begin(tmp_path, bench.lab)
    for records in (4, 12, 19, 30):
        wait_for_records(process, tmp_path, records)
        process.send_signal(signal.SIGKILL)
        process.communicate()
        process = subprocess.Popen(
            [*COMMAND, "resume", "last", "--runs", str(tmp_path / "runs")],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
    process.communicate()

    folder = journal_of(tmp_path).parent
    assert process.returncode == 0
    shots = done(bench, folder.name, "shoot")
    assert sorted(shots) == ["end", "shot0", "shot1", "shot2", "shot3"]


@pytest.mark.slow
def test_what_was_lowered_is_lowered_again_before_the_shot_after_the_device_was_touched(
    tmp_path, bench
):
    text = PROTOCOL.replace(
        'name: "shot${{ i }}", seconds: 0.05', 'name: "shot${{ i }}", script: Broken'
    )
    process = begin(tmp_path, bench.lab, text)
    assert process.wait() == 1

    resume(tmp_path)

    folder = journal_of(tmp_path).parent
    names = [c["name"] for c in bench.calls(folder.name) if c["word"] in ("ok", "Broken")]
    assert names.count("lower0") == 2
    last_shot = len(names) - 1 - names[::-1].index("shot0")
    assert names[last_shot - 1] == "lower0"


@pytest.mark.slow
def test_a_failed_run_goes_on_with_its_retries_anew_when_it_is_resumed(tmp_path, bench):
    text = PROTOCOL.replace(
        'script: "Broken,ok"}, retry: 3', 'script: "Broken,Broken,ok"}, retry: 2'
    )
    process = begin(tmp_path, bench.lab, text)
    assert process.wait() == 1

    went_on = resume(tmp_path)

    folder = journal_of(tmp_path).parent
    assert went_on.returncode == 1  # point 1 has two earlier failures
    assert done(bench, folder.name, "shoot").count("shot0") == 1


@pytest.mark.slow
def test_what_a_fallback_had_done_is_not_done_again_after_a_later_failure(tmp_path, bench):
    text = (
        "labrun: 1\nname: later\ndevices: {a: scripted@1, b: scripted@1}\nsteps:\n"
        "  - do: a.shoot\n    with: {name: x, script: Broken}\n"
        "    fallback: [{do: a.shoot, with: {name: y}}]\n"
        "  - {do: b.act, with: {name: late, script: 'Broken,ok'}}\n"
    )
    first = begin(tmp_path, bench.lab, text)
    assert first.wait() == 1
    went_on = resume(tmp_path)

    name = journal_of(tmp_path).parent.name
    assert went_on.returncode == 0, went_on.stderr
    assert [c["name"] for c in bench.calls(name) if c["word"] != "done"] == [
        "x",
        "y",
        "late",
        "late",
    ]


@pytest.mark.slow
def test_a_run_is_resumed_from_within_its_own_folder(tmp_path, bench):
    process = begin(tmp_path, bench.lab)
    wait_for_records(process, tmp_path, 9)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    folder = journal_of(tmp_path).parent
    went_on = subprocess.run([*COMMAND, "resume", "."], cwd=folder, capture_output=True, text=True)

    assert went_on.returncode == 0, went_on.stderr
    shots = done(bench, folder.name, "shoot")
    assert sorted(shots) == ["end", "shot0", "shot1", "shot2", "shot3"]


@pytest.mark.slow
def test_a_run_that_has_succeeded_is_not_resumed(tmp_path, bench):
    assert begin(tmp_path, bench.lab).wait() == 0

    again = resume(tmp_path)

    assert again.returncode == 2
    assert "has already succeeded" in again.stderr


@TO_ONE
@pytest.mark.slow
def test_a_second_engine_is_refused_while_the_first_lives(tmp_path, bench):
    text = PROTOCOL.replace("name: begin", "name: begin, seconds: 5")
    process = begin(tmp_path, bench.lab, text)
    wait_for_records(process, tmp_path, 3)

    second = resume(tmp_path)
    os.kill(process.pid, signal.SIGINT)
    process.communicate()

    assert second.returncode == 2
    assert "another engine" in second.stderr
    assert process.returncode == 130


def test_resume_of_no_run_says_so(tmp_path):
    (tmp_path / "runs").mkdir()

    nothing = subprocess.run(
        [*COMMAND, "resume", "nope", "--runs", str(tmp_path / "runs")],
        capture_output=True, text=True,
    )  # fmt: skip

    assert nothing.returncode == 2
    assert "no run 'nope'" in nothing.stderr
    assert "Traceback" not in nothing.stderr


@pytest.mark.slow
def test_a_parameter_without_a_default_is_known_again_on_resume(tmp_path, bench):
    text = PROTOCOL.replace("steps:\n", "params: {who: {type: string}}\nsteps:\n", 1).replace(
        "name: begin}", 'name: "${{ params.who }}", script: "Broken,ok"}'
    )
    (tmp_path / "killed.yaml").write_text(text)
    first = subprocess.run(
        [*COMMAND, "run", str(tmp_path / "killed.yaml"), "--lab", str(bench.lab), "-p", "who=me",
         "--runs", str(tmp_path / "runs")],
        capture_output=True, text=True,
    )  # fmt: skip

    went_on = resume(tmp_path)

    assert first.returncode == 1
    assert went_on.returncode == 0, went_on.stderr
    assert done(bench, journal_of(tmp_path).parent.name, "act").count("me") == 1


@pytest.mark.slow
def test_an_action_lost_with_engine_and_server_is_done_again_and_is_no_failure(tmp_path):
    here = Path(__file__).parents[1] / "scripted_lab"
    lab = tmp_path / "lab.yaml"
    lab.write_text(
        f"name: own\ncontracts: [{here / 'scripted.yaml'}]\n"
        f"devices: {{a: {{contract: scripted@1, driver: '{here / 'scripted.py'}:Scripted'}}}}\n"
    )
    text = (
        "labrun: 1\nname: both\ndevices: {a: scripted@1}\n"
        "steps: [{do: a.act, with: {name: x, seconds: 1}}]\n"
    )
    process = begin(tmp_path, lab, text)
    wait_for_records(process, tmp_path, 3)
    time.sleep(0.2)
    process.send_signal(signal.SIGKILL)
    process.wait()
    folder = journal_of(tmp_path).parent
    server = json.loads((folder / "servers" / "a" / "server.json").read_text())
    os.kill(server["pid"], signal.SIGKILL)

    went_on = resume(tmp_path)

    assert went_on.returncode == 0, went_on.stdout + went_on.stderr
    ended = [r for r in read_records(folder / "journal.jsonl") if r.kind == "ended"]
    assert [(r.state, r.error and r.error.name) for r in ended if "/main/" in r.id] == [
        ("ABORTED", "Lost"),
        ("SUCCEEDED", None),
    ]
