"""A full disk is named before a run is started on it."""

import shutil

from labrun.web.local.room import no_room


def test_what_is_left_is_told_if_it_is_too_little(tmp_path, monkeypatch):
    asked = []

    def usage(path):
        asked.append(path)
        return shutil._ntuple_diskusage(100_000_000, 97_000_000, 3_000_000)

    folder = tmp_path / "runs"  # made by the first run
    before = no_room(folder)
    monkeypatch.setattr(shutil, "disk_usage", usage)

    assert before == ""
    assert no_room(folder) == (f"the disk of {folder} has 3.0 MB left; a run needs 20 MB at least")
    assert asked == [tmp_path]


def test_a_disk_that_cannot_be_asked_is_in_nobodys_way(tmp_path, monkeypatch):
    def usage(path):
        raise OSError("it is gone")

    monkeypatch.setattr(shutil, "disk_usage", usage)

    assert no_room(tmp_path) == ""
