"""One action by hand: it is cancelled, not forgotten, when the command is asked to end."""

import json
import os
import re
import signal
import subprocess
import sys
import time

import pytest

from ...ctrl_c import TO_ONE
from ...found import found

COMMAND = [sys.executable, "-m", "labrun.engine", "call"]
LAB = """
name: slow
simulated: true
devices:
  gantry: {contract: gantry@1, driver: sim_gantry, config: {clock: real, homed: true}}
"""


def called(folder, lab, *words):
    return subprocess.Popen(
        [*COMMAND, *words, "--lab", str(lab), "--yes"],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env={**os.environ, "TMPDIR": str(folder)},
    )  # fmt: skip


@TO_ONE
@pytest.mark.parametrize(
    ("number", "word", "status"),
    [(signal.SIGINT, "Ctrl-C", 130), (signal.SIGTERM, "SIGTERM", 1)],
)
def test_a_signal_cancels_the_action_and_says_where_things_stand(
    tmp_path, bench, number, word, status
):
    before = len(bench.calls())
    process = called(tmp_path, bench.lab, "a.act", "name=byhand", "seconds=60")
    while len(bench.calls()) == before:
        time.sleep(0.02)

    process.send_signal(number)
    _, said = process.communicate()

    assert process.returncode == status, said
    assert f"{word}: cancelling a.act" in said
    assert f"a.act was cancelled by {word} and ended CANCELED" in said
    assert "a now: " in said


def carriage(folder):
    """Where the simulated gantry really is: its own server keeps its world in a temporary folder."""
    path = found(folder, "gantry.json")
    return {"x": 0} if path is None else json.loads(path.read_text())


@TO_ONE
@pytest.mark.slow
def test_an_axis_does_not_drive_on_after_ctrl_c(tmp_path):
    lab = tmp_path / "lab.yaml"
    lab.write_text(LAB)
    process = called(tmp_path, lab, "gantry.move_to", "x=700 mm", "feed=60 mm/min")
    while carriage(tmp_path)["x"] < 1:
        time.sleep(0.02)
    beside = called(tmp_path, lab, "gantry.halt")
    _, refused = beside.communicate()
    process.send_signal(signal.SIGINT)
    _, said = process.communicate()

    assert beside.returncode == 4
    assert "held by call-" in refused and "`labrun stop gantry`" in refused
    assert process.returncode == 130, said
    (told,) = re.findall(r"gantry now: state idle.* x ([\d.]+)", said)
    assert 1 <= float(told) < 700


SLOW = """
import asyncio
from labrun.drivers.simulated.balance import SimBalance

class Slow(SimBalance):
    async def open(self):
        await super().open()
        await asyncio.sleep(600)
"""


@TO_ONE
@pytest.mark.slow
def test_ctrl_c_before_anything_was_sent_says_so(tmp_path):
    (tmp_path / "slow.py").write_text(SLOW)
    lab = tmp_path / "lab.yaml"
    lab.write_text(
        "name: slow\nstart_timeout: 500 s\n"
        "devices: {b: {contract: balance@1, driver: ./slow.py:Slow}}\n"
    )
    process = called(tmp_path, lab, "b.weigh")
    waiting = process.stderr.readline()

    process.send_signal(signal.SIGINT)
    _, said = process.communicate()

    assert "waiting for the server of b" in waiting
    assert process.returncode == 130
    assert said == "labrun: Ctrl-C: nothing was sent\n"
