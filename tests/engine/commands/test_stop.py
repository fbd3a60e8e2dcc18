"""Stop and status from another shell, past every lease."""

import os
import signal
import subprocess
import sys
import time

import pytest

from ...ctrl_c import TO_ONE
from ...found import found

COMMAND = [sys.executable, "-m", "labrun.engine"]
LAB = """
name: own
simulated: true
devices:
  gantry: {contract: gantry@1, driver: sim_gantry, config: {clock: real, homed: true}}
"""
SCAN = """labrun: 1
name: far
devices: {gantry: gantry@1}
steps: [{do: gantry.move_to, with: {x: 700 mm, y: 10 mm, z: 40 mm, feed: 60 mm/min}}]
"""


def labrun(folder, *words, tmpdir=None):
    environment = os.environ | ({"TMPDIR": str(tmpdir)} if tmpdir is not None else {})
    return subprocess.run(
        [*COMMAND, *map(str, words)], cwd=folder, env=environment, capture_output=True, text=True
    )


def read_until(process, words):
    """Its lines up to one with these words."""
    lines = [process.stdout.readline()]
    while words not in lines[-1]:
        assert lines[-1], f"it ended without {words!r}"
        lines.append(process.stdout.readline())
    return lines


def begun(bench, folder, name):
    """A call by hand that lasts."""
    before = len(bench.calls())
    process = subprocess.Popen(
        [*COMMAND, "call", "a.act", f"name={name}", "seconds=60", "--lab", str(bench.lab)],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    while len(bench.calls()) == before and process.poll() is None:
        time.sleep(0.02)
    return process


@pytest.mark.slow
def test_stop_goes_past_the_lease_of_a_call_which_hears_who_it_was(tmp_path, bench):
    process = begun(bench, tmp_path, "stopme")

    shown = labrun(tmp_path, "status", "a", "--lab", bench.lab)
    stopped = labrun(tmp_path, "stop", "a", "--lab", bench.lab)
    _, said = process.communicate()

    assert "held by call-" in shown.stdout
    assert (stopped.returncode, stopped.stdout.strip()) == (0, "a is in its safe state")
    assert process.returncode == 1
    assert "a was stopped by" in said and "labrun stop on" in said and "a now: " in said


def test_a_device_whose_server_does_not_answer_is_named(tmp_path):
    (tmp_path / "lab.yaml").write_text(
        "name: gone\ndevices:\n  gantry: {contract: gantry@1, url: 'http://127.0.0.1:9'}\n"
    )

    stopped = labrun(tmp_path, "stop", "--lab", "lab.yaml")
    shown = labrun(tmp_path, "status", "gantry", "--lab", "lab.yaml")

    assert stopped.returncode == shown.returncode == 1
    assert "gantry DID NOT CONFIRM" in stopped.stderr
    assert "no answer" in shown.stdout


def test_where_no_server_is_known_it_says_that_nothing_was_stopped(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    (tmp_path / "lab.yaml").write_text(LAB)

    stopped = labrun(tmp_path, "stop", "--lab", "lab.yaml")

    assert stopped.returncode == 1
    assert "NOTHING WAS STOPPED. If something moves" in stopped.stderr


@pytest.mark.slow
def test_a_call_of_another_lab_goes_on(tmp_path):
    for name in ("own", "other"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "lab.yaml").write_text(LAB)
    process = subprocess.Popen(
        [*COMMAND, "call", "gantry.move_to", "x=700 mm", "--yes", "--lab", "other/lab.yaml"],
        cwd=tmp_path, env={**os.environ, "TMPDIR": str(tmp_path)}, stderr=subprocess.PIPE,
    )  # fmt: skip
    until = time.monotonic() + 500
    while time.monotonic() < until and not found(tmp_path, "labrun-call-*/servers/*/server.json"):
        time.sleep(0.05)
    own, other = (
        labrun(tmp_path, "stop", "--lab", f"{name}/lab.yaml", tmpdir=tmp_path)
        for name in ("own", "other")
    )
    process.communicate(timeout=500)

    assert (own.returncode, other.returncode) == (1, 0)
    assert "NOTHING WAS STOPPED" in own.stderr
    assert other.stdout.strip() == "gantry is in its safe state"


def test_a_device_that_is_not_in_the_lab_is_refused(tmp_path, bench):
    stopped = labrun(tmp_path, "stop", "gantri", "--lab", bench.lab)

    assert stopped.returncode == 2
    assert "no device 'gantri'" in stopped.stderr


@TO_ONE
@pytest.mark.slow
def test_the_device_of_a_live_run_is_found_stopped_and_shown(tmp_path):
    (tmp_path / "lab.yaml").write_text(LAB)
    (tmp_path / "far.yaml").write_text(SCAN)
    looking = subprocess.Popen(
        [*COMMAND, "status", "gantry", "--follow", "--lab", "lab.yaml"],
        cwd=tmp_path, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    read_until(looking, "not served: nobody uses it")
    process = subprocess.Popen(
        [*COMMAND, "run", "far.yaml", "--lab", "lab.yaml"],
        cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    journal = None
    while journal is None or '"kind":"goal"' not in journal.read_text():
        journal = next(tmp_path.glob("runs/*/journal.jsonl"), None)
        time.sleep(0.05)
    read_until(looking, "moving")

    stopped = labrun(tmp_path, "stop", "--lab", "lab.yaml")
    read_until(looking, "gantry was stopped by")
    until = time.monotonic() + 500
    while '"verb":"pause"' not in journal.read_text() and time.monotonic() < until:
        time.sleep(0.05)
    shown = labrun(tmp_path, "status", "gantry", "--lab", "lab.yaml")
    labrun(tmp_path, "abort", "last")
    process.communicate()
    read_until(looking, "not served: nobody uses it")  # it goes on until Ctrl-C
    looking.send_signal(signal.SIGINT)
    looking.communicate()

    assert looking.returncode == 130
    assert stopped.returncode == 0, stopped.stderr
    assert "gantry was stopped by" in journal.read_text()
    assert "gantry was stopped by" in shown.stdout and "held by 2" in shown.stdout
    assert " x " in shown.stdout or "(x " in shown.stdout


@pytest.mark.slow
@pytest.mark.parametrize("words", ["serve lab.yaml", "web --lab lab.yaml --no-browser"])
def test_servers_of_other_commands_are_found_at_whatever_port(tmp_path, monkeypatch, words):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    (tmp_path / "lab.yaml").write_text(LAB)
    process = subprocess.Popen(
        [*COMMAND, *words.split(), "--port", "0"], cwd=tmp_path, text=True, start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    try:
        until = time.monotonic() + 500
        while time.monotonic() < until and not found(tmp_path, "server.json"):
            time.sleep(0.1)
        stopped = labrun(tmp_path, "stop", "--lab", "lab.yaml")
    finally:
        process.terminate()
        process.communicate(timeout=500)

    assert (stopped.returncode, stopped.stdout.strip()) == (0, "gantry is in its safe state")
