"""A device that `labrun serve` serves is found by the file that its server keeps."""

import json
import os
import subprocess
import sys

import pytest

from labrun.engine.dispatch.served_lab import serve_home, served_at
from labrun.engine.lab.lab import load_lab

LAB = "name: mine\nsimulated: true\ndevices: {b: {contract: balance@1, driver: sim_balance}}\n"
URL = "http://127.0.0.1:4107"


@pytest.fixture
def lab(tmp_path):
    (tmp_path / "lab.yaml").write_text(LAB)
    return load_lab(tmp_path / "lab.yaml")[0]


def told(lab, text):
    path = serve_home(lab) / "b" / "server.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text if isinstance(text, str) else json.dumps(text))


def test_it_is_found_while_its_server_lives(lab):
    told(lab, {"pid": os.getpid(), "url": URL, "devices": ["a", "b"]})

    assert served_at(lab, "b") == URL
    assert served_at(lab, "c") is None


def test_a_server_that_was_killed_and_a_file_that_is_not_whole_are_none(lab):
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()

    for text in ({"pid": dead.pid, "url": URL, "devices": ["b"]}, '{"pid": 1', "[]", '{"pid": 1}'):
        told(lab, text)
        assert served_at(lab, "b") is None


def test_the_simulated_lab_is_each_runs_own():
    lab = load_lab(None)[0]
    told(lab, {"pid": os.getpid(), "url": URL, "devices": ["balance"]})
    try:
        assert served_at(lab, "balance") is None
    finally:
        (serve_home(lab) / "b" / "server.json").unlink()
