"""Every file is hashed and held against the journal; what is working state is left out."""

import os
from hashlib import sha256

import pytest

from labrun.web.report.files import is_working, take_inventory


def digest(text):
    return sha256(text.encode()).hexdigest()


def test_files_are_as_the_journal_says_or_changed_or_gone(tmp_path):
    (tmp_path / "spectra").mkdir()
    (tmp_path / "spectra" / "a.csv").write_text("a")
    (tmp_path / "spectra" / "b.csv").write_text("changed")

    told = {f"spectra/{name}.csv": digest(name) for name in "abc"}
    inventory = take_inventory(tmp_path, told)

    assert [file.path for file in inventory.files] == ["spectra/a.csv", "spectra/b.csv"]
    assert [file.path for file in inventory.changed] == ["spectra/b.csv"]
    assert [file.path for file in inventory.missing] == ["spectra/c.csv"]
    assert inventory.files[0].sha256 == digest("a")


def test_the_engines_and_the_servers_working_state_is_left_out_and_so_are_the_reports(tmp_path):
    for name in ("engine.lock", "control.json", "journal.reserve", ".data.csv.part", "data.csv"):
        (tmp_path / name).write_text("x")
    for name in ("report.html", "ro-crate-metadata.json"):
        (tmp_path / name).write_text("x")
    (tmp_path / "servers" / "libs").mkdir(parents=True)
    (tmp_path / "servers" / "libs" / "ledger.sqlite").write_text("x")

    inventory = take_inventory(tmp_path, {})

    assert [file.path for file in inventory.files] == ["data.csv"]
    assert len(inventory.working) == 5
    assert not is_working("spectra/servers.csv")


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such files")
def test_links_to_folders_and_pipes_are_not_followed(tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "secret.txt").write_text("x")
    (tmp_path / "run" / "link").symlink_to(tmp_path / "elsewhere")
    (tmp_path / "run" / "gone").symlink_to(tmp_path / "nowhere")
    os.mkfifo(tmp_path / "run" / "pipe")

    assert take_inventory(tmp_path / "run", {}).files == []
