"""The lab of the paper's bench: the shipped map checks clean against it, and nothing is simulated."""

import subprocess
import sys
from importlib.resources import files
from pathlib import Path

from labrun.drivers.aecp.driver import Aecp
from labrun.drivers.driver import Place
from labrun.engine.lab.lab import load_lab

LAB = Path(str(files("labrun.protocols.labs"))) / "aecp.yaml"
MAP = Path(str(files("labrun.protocols"))) / "pegmatite_map.yaml"


def test_the_map_checks_clean_against_it():
    done = subprocess.run(
        [sys.executable, "-m", "labrun.engine", "check", str(MAP), "--lab", str(LAB)],
        capture_output=True, text=True,
    )  # fmt: skip

    assert done.returncode == 0, done.stdout + done.stderr
    assert "no problems" in done.stdout + done.stderr


def test_a_map_beyond_the_bench_is_refused_before_anything_is_sent():
    done = subprocess.run(
        [sys.executable, "-m", "labrun.engine", "check", str(MAP), "--lab", str(LAB), "-p", "x0=729 mm"],
        capture_output=True, text=True,
    )  # fmt: skip

    assert done.returncode == 2, done.stdout + done.stderr
    assert "730" in done.stdout + done.stderr


def test_its_words_are_those_that_the_driver_knows(tmp_path):
    lab, problems = load_lab(LAB)

    assert problems == []
    assert lab is not None and not lab.lab.simulated
    Aecp(Place("libs", dict(lab.lab.devices["libs"].config), {}, tmp_path, tmp_path))
