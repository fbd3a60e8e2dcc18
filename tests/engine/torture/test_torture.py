"""Real runs, really killed; and a device that breaks the promise is detected."""

import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
PROTOCOL = """labrun: 1
name: tiny
devices: {gantry: gantry@1, libs: libs_analyzer@1}
steps:
  - id: scan
    foreach: {x: "${{ range(3) }}"}
    steps:
      - {id: lower, do: gantry.move_to, with: {x: 2, y: 2, z: 0}}
      - {id: shoot, do: libs.measure}
    collect: {shot: "${{ steps.shoot.shot_id }}"}
"""
LAB = """name: l
simulated: SIMULATED
devices:
  gantry: {contract: gantry@1, driver: sim_gantry, config: {clock: fast, homed: true}}
  libs: {contract: libs_analyzer@1, driver: DRIVER, config: {clock: fast, gantry: gantry}}
"""


def torture(folder, *options, driver="sim_libs", simulated="true", protocol=PROTOCOL):
    (folder / "tiny.yaml").write_text(protocol)
    (folder / "lab.yaml").write_text(
        LAB.replace("DRIVER", f"'{driver}'").replace("SIMULATED", simulated)
    )
    return subprocess.run(
        [sys.executable, "-m", "labrun.engine", "torture", "tiny.yaml", "--lab", "lab.yaml",
         *options],
        cwd=folder, capture_output=True, text=True,
    )  # fmt: skip


@pytest.mark.soak  # CI calls the command itself
@pytest.mark.timeout(300)
def test_random_kills_are_made_counted_and_survived(tmp_path):
    ended = torture(tmp_path, "--kills", "3", "--seed", "5")
    dealt = ended.stdout.partition("work done")[0]
    counts = [
        int(line.split()[-1]) for line in dealt.splitlines()[1:] if "wire" not in line and line
    ]

    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert sum(counts) == 3
    assert ended.stdout.count(" 0 broken") == 8
    assert list((tmp_path / "runs").iterdir()) == []  # nothing is left of runs without a breach


@pytest.mark.soak
@pytest.mark.timeout(600)
def test_a_blow_at_every_write_of_the_journal_is_survived(tmp_path):
    ended = torture(tmp_path)

    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert "write 10 of the journal" in ended.stderr


@pytest.mark.soak
@pytest.mark.timeout(300)
def test_a_device_that_fires_twice_is_found_out_and_its_run_is_kept(tmp_path):
    ended = torture(
        tmp_path, "--kills", "1", "--no-wires", driver=f"{HERE / 'trigger_happy.py'}:TriggerHappy"
    )

    assert ended.returncode == 1, ended.stdout + ended.stderr
    assert "libs did shot 2 times for main/scan/0/shoot" in ended.stdout
    assert "no `once` action was done twice                      3 broken" in ended.stdout
    assert len(list((tmp_path / "runs").glob("*/*/runs/*/journal.jsonl"))) == 1


@pytest.mark.posix("torture needs SIGKILL")
def test_a_lab_with_real_devices_is_never_tortured(tmp_path):
    ended = torture(tmp_path, "--kills", "1", simulated="false")

    assert ended.returncode == 2
    assert "l is not a simulated lab" in ended.stderr
    assert not (tmp_path / "runs").exists()


@pytest.mark.slow
def test_a_protocol_that_fails_undisturbed_is_said(tmp_path):
    failing = PROTOCOL + "  - {fail: 'no argon'}\n"
    ended = torture(tmp_path, "--kills", "1", protocol=failing)

    assert ended.returncode == 1
    assert "undisturbed, the run does not succeed" in ended.stderr
    assert "no argon" in ended.stderr
