"""A file is the old one or the new one, whole."""

import contextlib
import os
import tempfile
from pathlib import Path

import pytest

from labrun.system import files
from labrun.system.files import lock_file, lock_of_this_computer, write_whole

posix = pytest.mark.skipif(os.name == "nt", reason="permissions and links of POSIX")


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_a_file_is_replaced_and_nothing_else_stays(tmp_path):
    path = tmp_path / "new folder" / "note.txt"
    write_whole(path, b"first")
    write_whole(path, b"second")

    assert path.read_bytes() == b"second"
    assert names(path.parent) == ["note.txt"]


@posix
def test_a_file_that_is_replaced_keeps_its_permissions_and_its_link(tmp_path):
    real = tmp_path / "real.yaml"
    real.write_text("old")
    real.chmod(0o640)
    link = tmp_path / "link.yaml"
    link.symlink_to(real)
    write_whole(link, b"new")

    assert link.is_symlink() and real.read_text() == "new"
    assert real.stat().st_mode & 0o777 == 0o640


@posix
def test_a_secret_is_never_readable_by_others(tmp_path):
    write_whole(tmp_path / "token", b"secret", mode=0o600)

    assert (tmp_path / "token").stat().st_mode & 0o777 == 0o600


@posix
@pytest.mark.parametrize(("knows_it", "asked"), [(True, ["full"]), (False, ["full", "fsync"])])
def test_macos_is_asked_to_empty_the_cache_of_its_disk_and_otherwise_to_sync(
    tmp_path, monkeypatch, knows_it, asked
):
    calls = []

    def full_sync(descriptor, number):
        calls.append(number)
        if not knows_it:
            raise OSError(45, "Operation not supported")

    monkeypatch.setattr(files, "FULL_SYNC", "full")
    monkeypatch.setattr(files.fcntl, "fcntl", full_sync)
    monkeypatch.setattr(os, "fsync", lambda _: calls.append("fsync"))
    with (tmp_path / "note").open("w") as file:
        files.sync_file(file.fileno())

    assert calls == asked


@posix
def test_where_it_cannot_be_written_the_old_one_is_left(tmp_path, monkeypatch):
    path = tmp_path / "note.txt"
    path.write_text("old")

    def full(_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        write_whole(path, b"new")

    assert path.read_text() == "old"
    assert names(tmp_path) == ["note.txt"]


def test_a_folder_in_its_place_is_told_and_nothing_else_stays(tmp_path):
    (tmp_path / "report.html").mkdir()

    with pytest.raises(OSError):
        write_whole(tmp_path / "report.html", b"page")

    assert names(tmp_path) == ["report.html"]


@contextlib.contextmanager
def as_somebody_else(root):
    if root:
        os.seteuid(65534)
    try:
        yield
    finally:
        if root:
            os.seteuid(0)


@posix
def test_a_lock_of_another_user_can_be_had_when_it_is_free_and_is_seen_when_it_is_not():
    name = f"test_{os.getpid()}"
    path = Path(tempfile.gettempdir()) / f"labrun_{name}.lock"
    root = os.geteuid() == 0
    try:
        with lock_of_this_computer(name) as theirs:
            if not root:
                path.chmod(0o444)
            with as_somebody_else(root), lock_of_this_computer(name) as ours:
                assert not ours.writable()
                lock_file(ours)
                with pytest.raises(OSError):
                    lock_file(theirs)
                ours.close()
                lock_file(theirs)
    finally:
        path.unlink()
