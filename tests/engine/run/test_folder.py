"""One engine holds a run's folder; a check whether there is one never gets in its way."""

import errno
import json
import os
import re
import shutil
import threading
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from labrun.engine.lab.lab import load_lab
from labrun.engine.run.folder import (
    JOURNAL,
    FolderFault,
    FolderLock,
    engine_of,
    find_run,
    is_live,
    keep_inputs,
)  # fmt: skip
from labrun.schemas.lab import Lab


def test_a_folder_is_live_as_long_as_its_engine_holds_it(tmp_path):
    engine = FolderLock(tmp_path)
    before = is_live(tmp_path)
    engine.take()
    held = is_live(tmp_path)
    engine.release()

    assert (before, held, is_live(tmp_path)) == (False, True, False)


def test_what_may_only_be_read_is_not_live_for_that(tmp_path, monkeypatch):
    engine, opened = FolderLock(tmp_path), Path.open
    engine.take()

    def only_read(path, mode="r", **options):
        if mode == "a+":
            raise OSError(errno.EROFS, "Read-only file system")
        return opened(path, mode, **options)

    monkeypatch.setattr(Path, "open", only_read)
    held = is_live(tmp_path)
    engine.release()

    assert (held, is_live(tmp_path)) == (True, False)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("nope", "no run"),
        ("a" * 300, "no run"),
        ("", "no run"),
        ("scan.yaml", "`labrun scan.yaml` begins"),
    ],
)
def test_a_name_of_no_run_is_refused(tmp_path, name, words, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scan.yaml").touch()

    with pytest.raises(FolderFault, match=words):
        find_run(tmp_path, name)


def test_the_last_run_stays_the_last_when_a_backup_is_put_back(tmp_path):
    """`tar` and `cp -a` keep when a file was written, in whatever order they write the files."""
    for name, written in (("2026_newer_b", 2000), ("2026_older_a", 1000)):
        (tmp_path / name).mkdir()
        (tmp_path / name / JOURNAL).touch()
        os.utime(tmp_path / name / JOURNAL, (written, written))

    assert find_run(tmp_path, "last").name == "2026_newer_b"


def test_a_second_engine_is_told_that_there_is_one(tmp_path):
    first = FolderLock(tmp_path)
    first.take()

    with pytest.raises(FolderFault, match=f"another engine is running {tmp_path.name}"):
        FolderLock(tmp_path).take()
    first.release()


def test_a_copy_of_a_run_is_not_gone_on_with_beside_the_run_itself(tmp_path):
    """Each would do what the other has done since."""
    folder, copy = tmp_path / "runs" / "a", tmp_path / "copies" / "a"
    engine = FolderLock(folder)
    folder.mkdir(parents=True)
    (folder / JOURNAL).write_text("started\n")
    engine.take()
    engine.release()
    shutil.copytree(folder, copy)
    with (copy / JOURNAL).open("a") as journal:
        journal.write("more\n")

    with pytest.raises(
        FolderFault, match=re.escape(f"a is a copy of {folder}, which is still there")
    ):
        FolderLock(copy).take()
    folder.rename(tmp_path / "elsewhere")
    engine = FolderLock(copy)
    engine.take()
    engine.release()

    assert engine_of(copy) == os.getpid()


def test_an_engine_gets_its_folder_although_others_look_at_it_all_the_time(tmp_path):
    (tmp_path / "engine.lock").touch()
    (tmp_path / JOURNAL).touch()
    over = threading.Event()

    def look():
        while not over.is_set():
            is_live(tmp_path)

    lookers = [threading.Thread(target=look) for _ in range(3)]
    for looker in lookers:
        looker.start()
    try:
        for _ in range(50):
            engine = FolderLock(tmp_path)
            engine.take()
            engine.release()
    finally:
        over.set()
        for looker in lookers:
            looker.join()


def test_a_run_keeps_where_the_folders_drivers_and_interpreters_of_its_lab_lie(tmp_path):
    """A resume reads the copy, which lies elsewhere."""
    lab = Lab.model_validate({
        "folders": ["../shared"],
        "devices": {
            "oven": {"contract": "oven@1", "driver": "./oven.py:Oven", "python": "./env/bin/python"},
            "lamp": {"contract": "lamp@1", "driver": "lamp", "python": "python3.12"},
        }
    })  # fmt: skip
    folder = tmp_path / "run"
    folder.mkdir()
    keep_inputs(folder, "labrun: 1\n", "p.yaml", lab, tmp_path / "labs", {}, {})
    copy = YAML(typ="safe").load(folder / "lab.yaml")
    kept = copy["devices"]

    assert copy["folders"] == [str(tmp_path / "shared")]
    assert kept["oven"]["driver"] == f"{tmp_path / 'labs' / 'oven.py'}:Oven"
    assert kept["oven"]["python"] == str(tmp_path / "labs" / "env" / "bin" / "python")
    assert kept["lamp"]["python"] == "python3.12"


def test_a_run_keeps_the_order_of_what_its_lab_says(tmp_path):
    """Values come in the order of `returns`, and registers are written in that of `write`."""
    where = {"y": {"unit": "mm"}, "x": {"unit": "mm"}, "at": {"words": {"rest": 1, "end": 0}}}
    press = {"target": 5, "command": 1}
    both = {"resource": "127.0.0.1:9"}
    text = {**both, "actions": {"where": {"send": "W", "effect": "pure", "returns": where}}}
    registers = {"target": {"holding": 1}, "command": {"holding": 2}}
    modbus = {**both, "registers": registers, "actions": {"press": {"write": press}}}
    devices = {
        "d": {"driver": "text", "config": text},
        "p": {"driver": "modbus", "config": modbus},
    }
    (tmp_path / "lab.yaml").write_text(json.dumps({"devices": devices}), "utf-8")
    lab, _ = load_lab(tmp_path / "lab.yaml")
    folder = tmp_path / "run"
    folder.mkdir()
    keep_inputs(folder, "labrun: 1\n", "p.yaml", lab.lab, tmp_path, lab.contracts, {})

    kept, problems = load_lab(folder / "lab.yaml")

    assert problems == []
    assert list(kept.contracts["d@1"].actions["where"].returns["properties"]) == list(where)
    assert list(kept.lab.devices["p"].config["actions"]["press"]["write"]) == list(press)
