"""A device that `labrun serve` serves is found by the file that its server keeps."""

import asyncio
import json
import os
import subprocess
import sys

import pytest

from labrun.drivers.client.launch import ServerFailed
from labrun.engine.check import check_file
from labrun.engine.commands.call import role_of
from labrun.engine.dispatch.connect import NotReached, connect
from labrun.engine.dispatch.served_lab import (
    serve_home,
    served_at,
    serves_in,
    serving_folders,
    started_by,
    starting,
)
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


def test_one_that_is_just_being_served_is_waited_for_not_served_twice(lab, tmp_path):
    said = []

    async def story():
        async def serve():
            while not said:  # noqa: ASYNC110 - it is told once
                await asyncio.sleep(0.01)
            told(lab, {"pid": os.getpid(), "url": "http://127.0.0.1:9", "devices": ["b"]})

        serving = asyncio.create_task(serve())
        with (
            starting(lab, ["a", "b"]),
            pytest.raises(NotReached, match="device 'b' at http"),
        ):
            await connect({"b": role_of(lab, "b")}, lab, tmp_path / "run", "me", say=said.append)
        await serving

    asyncio.run(story())

    assert said[0] == f"waiting for `labrun serve` (process {os.getpid()}), which starts b"
    assert started_by(lab, "b") is None


def test_one_that_another_command_has_begun_to_serve_meanwhile_is_used(lab, tmp_path, monkeypatch):
    async def too_late(*_, **__):
        told(lab, {"pid": os.getpid(), "url": "http://127.0.0.1:9", "devices": ["b"]})
        raise ServerFailed("the balance has a device server already")

    monkeypatch.setattr("labrun.engine.dispatch.connect.start_patiently", too_late)

    with pytest.raises(NotReached, match="device 'b' at http"):
        asyncio.run(connect({"b": role_of(lab, "b")}, lab, tmp_path / "run", "me"))


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
