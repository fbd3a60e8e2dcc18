"""A device that `labrun serve` serves is found by the file that its server keeps."""

import json
import os
import subprocess
import sys

import pytest

from labrun.engine.check import check_file
from labrun.engine.dispatch.served_lab import serve_home, served_at, serves_in, serving_folders
from labrun.engine.lab.lab import load_lab
from labrun.engine.run.folder import new_run_folder
from labrun.engine.runner.begin import keep
from labrun.engine.runner.change import check_copy

LAB = "name: mine\nsimulated: true\ndevices: {b: {contract: balance@1, driver: sim_balance}}\n"
URL = "http://127.0.0.1:4107"


@pytest.fixture
def lab(tmp_path):
    (tmp_path / "lab.yaml").write_text(LAB)
    return load_lab(tmp_path / "lab.yaml")[0]


def told(lab, text, folder=None):
    path = (folder or serve_home(lab)) / "b" / "server.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text if isinstance(text, str) else json.dumps(text))


def test_it_is_found_while_its_server_lives(lab):
    told(lab, {"pid": os.getpid(), "url": URL, "devices": ["a", "b"]})

    assert served_at(lab, "b") == URL
    assert served_at(lab, "c") is None


def test_it_is_found_in_a_folder_that_a_person_has_chosen(lab, tmp_path):
    for folder in ("mine", "and mine", "mine"):
        serves_in(lab, tmp_path / folder)
    told(lab, {"pid": os.getpid(), "url": URL, "devices": ["b"]}, tmp_path / "mine")

    assert served_at(lab, "b") == URL
    assert serving_folders(lab) == [serve_home(lab), tmp_path / "mine", tmp_path / "and mine"]


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


def test_a_resumed_run_finds_the_server_that_its_lab_file_has(lab, tmp_path):
    """The run's copy of the lab lies elsewhere; another server would be another ledger."""
    told(lab, {"pid": os.getpid(), "url": URL, "devices": ["b"]})
    protocol = tmp_path / "weigh.yaml"
    protocol.write_text(
        "labrun: 1\nname: w\ndevices: {b: balance@1}\nsteps: [{do: b.zero}]\n", encoding="utf-8"
    )
    folder = new_run_folder(tmp_path / "runs", "w")
    keep(folder, check_file(protocol, lab=tmp_path / "lab.yaml"), {})
    copied, _ = check_copy(folder)

    assert copied.lab is not None
    assert served_at(copied.lab, "b") == URL
