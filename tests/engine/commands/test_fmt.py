"""`labrun fmt` as a person runs it."""

import subprocess
from pathlib import Path

import pytest

from ...command_line import labrun

UNEVEN = "labrun: 1\nname: even # a name\nsteps:\n- log: hello\n"
EVEN = "labrun: 1\nname: even # a name\nsteps:\n  - log: hello\n"


def fmt(*arguments: object, stdin: bytes = b"") -> subprocess.CompletedProcess[bytes]:
    done = labrun(Path(), "fmt", *arguments, stdin=stdin)
    told = done.stdout.encode(), done.stderr.encode()
    return subprocess.CompletedProcess(done.args, done.returncode, *told)


@pytest.fixture
def uneven(tmp_path) -> Path:
    path = tmp_path / "uneven.yaml"
    path.write_bytes(UNEVEN.encode())
    return path


def test_files_are_written_in_even_form_and_keep_their_rights(uneven, tmp_path):
    uneven.chmod(0o640)
    link = tmp_path / "link.yaml"
    link.symlink_to(uneven)
    done = fmt(link)

    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")
    assert uneven.read_bytes().decode() == EVEN
    assert uneven.stat().st_mode & 0o777 == 0o640
    assert link.is_symlink()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["link.yaml", "uneven.yaml"]


def test_check_says_which_files_would_change_and_writes_nothing(uneven, tmp_path):
    even = tmp_path / "even.yaml"
    even.write_bytes(EVEN.encode())
    done, fine = fmt("--check", uneven, even), fmt("--check", even)

    assert (done.returncode, fine.returncode) == (1, 0)
    assert done.stderr.decode().splitlines() == [f"labrun: {uneven} would be reformatted"]
    assert uneven.read_bytes().decode() == UNEVEN


def test_diff_shows_what_would_change_and_writes_nothing(uneven):
    done, checked = fmt("--diff", uneven), fmt("--diff", "--check", uneven)

    assert (done.returncode, checked.returncode) == (0, 1)
    assert b"-- log: hello\n+  - log: hello\n" in done.stdout
    assert uneven.read_bytes().decode() == UNEVEN


def test_a_file_that_is_not_yaml_is_told_and_the_others_are_written(uneven, tmp_path):
    broken = tmp_path / "broken.yaml"
    broken.write_bytes(b"a:\n\tb: 1\n")
    done = fmt(broken, uneven, tmp_path / "none.yaml")

    assert done.returncode == 2
    assert b"broken.yaml:2:1: error[E101]" in done.stderr and b"error[E100]" in done.stderr
    assert broken.read_bytes() == b"a:\n\tb: 1\n"
    assert uneven.read_bytes().decode() == EVEN


def test_stdin_is_answered_on_stdout_with_its_line_ends():
    windows = UNEVEN.replace("\n", "\r\n").encode()
    done, again = fmt("-", stdin=windows), fmt("-", stdin=EVEN.encode())
    broken = fmt("-", stdin=b"a: [1")

    assert done.stdout == EVEN.replace("\n", "\r\n").encode()
    assert again.stdout == EVEN.encode()
    assert (broken.returncode, broken.stdout) == (2, b"")
    assert b"<stdin>:1:4: error[E101]" in broken.stderr
