"""The mixed lab: a real balance (here an emulator on a real serial line) beside simulated devices."""

import csv
import importlib.util
import subprocess
import sys
from importlib.resources import files
from pathlib import Path

import pytest

from labrun.engine.lab.lab import load_lab

pytestmark = pytest.mark.posix("Windows has no pseudo-terminals")
MIXED = Path(str(files("labrun.protocols.labs"))) / "mixed.yaml"
EMULATOR = Path(__file__).parents[1] / "drivers" / "balance" / "balance_emulator.py"


def emulator(link: Path, **moods):
    spec = importlib.util.spec_from_file_location("balance_emulator", EMULATOR)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.BalanceEmulator(link, **moods)


def labrun(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    text = MIXED.read_text(encoding="utf-8").replace("/dev/ttyUSB0", str(folder / "balance"))
    (folder / "lab.yaml").write_text(text.replace("clock: real", "clock: fast"))
    return subprocess.run(
        [sys.executable, "-m", "labrun.engine", *words, "--lab", "lab.yaml"],
        cwd=folder, capture_output=True, text=True,
    )  # fmt: skip


def test_it_is_a_lab_without_a_problem_and_says_that_something_is_real():
    lab, problems = load_lab(MIXED)

    assert problems == []
    assert lab is not None and not lab.lab.simulated
    assert lab.lab.devices["balance"].driver == "balance"


@pytest.mark.soak
def test_a_protocol_weighs_on_the_real_balance_what_the_simulated_pipette_does_not_drop(tmp_path):
    assert labrun(tmp_path, "check", "lab.yaml").returncode == 2  # a lab is not a protocol
    made = subprocess.run(
        [sys.executable, "-m", "labrun.engine", "new", "portions", "--template", "dispense"],
        cwd=tmp_path, check=True, capture_output=True,
    )  # fmt: skip
    with emulator(tmp_path / "balance", load_g=1.25) as balance:
        done = labrun(
            tmp_path, "run", "portions.yaml", "--runs", "runs", "-p", "volumes=[50 uL, 100 uL]"
        )
        heard = list(balance.heard)
    (run,) = (tmp_path / "runs").iterdir()
    with (run / "data.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))

    assert made.returncode == 0
    assert done.returncode == 0, done.stderr
    assert [float(row["mass_g"]) for row in rows] == [0.0, 0.0]  # above the tare of 1.25 g
    assert heard.count("T") == 1


def test_the_small_tips_of_the_bench_are_in_the_check(tmp_path):
    (tmp_path / "p.yaml").write_text(
        "labrun: 1\nname: p\ndevices: {pipette: pipette@1}\n"
        "steps: [{do: pipette.aspirate, with: {volume: 300 uL}}]\n"
    )
    done = labrun(tmp_path, "check", "p.yaml")

    assert done.returncode == 2
    assert "300 uL is outside volume 1..200 uL" in done.stdout + done.stderr


def test_a_balance_that_is_not_there_is_named_with_its_port_before_anything_is_done(tmp_path):
    done = labrun(tmp_path, "call", "balance.weigh")

    assert done.returncode == 4
    assert f"there is no port {tmp_path / 'balance'}: is the cable plugged in?" in done.stderr
    assert "Nothing was sent." in done.stderr
