"""A device that loses its state under a running engine gets it back before any `once` action."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from labrun.engine.journal.journal import read_records

HERE = Path(__file__).parents[1] / "scripted_lab"
PROTOCOL = """labrun: 1
name: touched
devices: {a: scripted@1, b: scripted@1}
steps:
  - id: scan
    foreach: {i: "${{ range(2) }}"}
    steps:
      - {id: lower, do: a.act, with: {name: "lower${{ i }}"}}
      - {id: pause, do: b.act, with: {name: "pause${{ i }}", seconds: 2}}
      - {id: shoot, do: a.shoot, with: {name: "shot${{ i }}"}}
    collect: {i: "${{ i }}", shot: "${{ steps.shoot.name }}"}
on_resume:
  - {do: a.act, with: {name: home}}
"""


def begin(folder):
    device = f"{{contract: scripted@1, driver: '{HERE / 'scripted.py'}:Scripted'}}"
    (folder / "lab.yaml").write_text(
        f"name: own\nsimulated: true\ncontracts: [{HERE / 'scripted.yaml'}]\n"
        f"devices: {{a: {device}, b: {device}}}\n"
    )
    (folder / "p.yaml").write_text(PROTOCOL)
    return subprocess.Popen(
        [sys.executable, "-m", "labrun.engine", "run", "p.yaml", "--lab", "lab.yaml"],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip


def calls(run):
    log = run / "servers" / "world" / "calls.jsonl"
    lines = log.read_text().splitlines() if log.exists() else []
    told = [json.loads(line) for line in lines]
    return [entry["name"] for entry in told if entry.get("word") not in ("done", None)]


def wait_for(folder, name):
    until = time.monotonic() + 500
    while time.monotonic() < until:
        runs = list((folder / "runs").glob("*")) if (folder / "runs").exists() else []
        if runs and name in calls(runs[0]):
            return runs[0]
        time.sleep(0.01)
    raise AssertionError(f"{name} never came")


@pytest.mark.slow
@pytest.mark.parametrize("device", ["a", "b"])
def test_what_a_restarted_device_had_is_set_again_before_the_shot(tmp_path, device):
    process = begin(tmp_path)
    run = wait_for(tmp_path, "pause1")
    server = json.loads((run / "servers" / device / "server.json").read_text())
    os.kill(server["pid"], signal.SIGKILL)
    told, _ = process.communicate()
    names = calls(run)

    assert process.returncode == 0, told
    assert names.count("shot0") == names.count("shot1") == 1
    assert names.count("lower0") == 1
    after = names[names.index("home") :]
    # `home` moved a: what the point had set on it is set again, whichever server was restarted.
    assert after.index("lower1") < after.index("shot1")
    assert "continuing from the journal" in told
    touched = [r for r in read_records(run / "journal.jsonl") if r.kind == "touched"]
    assert {(r.device, r.reason) for r in touched} == {(device, "its server was restarted")}
    assert (run / "data.csv").read_text().splitlines()[1:] == [
        "0,0,shot0,succeeded",
        "1,1,shot1,succeeded",
    ]
