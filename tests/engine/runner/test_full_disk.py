"""The disk is full from any write on: a message, the devices safe, and later every shot once."""

import subprocess
import sys

import pytest

from labrun.engine.journal.journal import read_records

PROTOCOL = """labrun: 1
name: full
devices: {a: scripted@1, b: scripted@1}
steps:
  - id: scan
    foreach: {i: "${{ range(4) }}"}
    steps:
      - {id: lower, do: a.act, with: {name: "lower${{ i }}"}}
      - {id: shoot, do: a.shoot, with: {name: "shot${{ i }}"}}
      - {id: look, do: b.act, with: {name: "look${{ i }}"}, mode: background}
    collect: {i: "${{ i }}", shot: "${{ steps.shoot.name }}"}
finally:
  - {do: b.act, with: {name: tidy}}
"""
FULL_FROM = """
import errno, os, pathlib, sys
left = int(sys.argv.pop(1))
write, open_path = os.write, pathlib.Path.open

def count():
    global left
    left -= 1
    if left <= 0:
        raise OSError(errno.ENOSPC, "No space left on device")

def full_write(file, data):
    count()
    return write(file, data)

def full_open(path, mode="r", *more, **named):
    if mode[0] in "wax" and "lock" not in path.name:
        count()
    return open_path(path, mode, *more, **named)

from labrun.engine.cli import main
os.write, pathlib.Path.open = full_write, full_open
main()
"""


def labrun(*words, full_from=None):
    begin = ["-m", "labrun.engine"] if full_from is None else ["-c", FULL_FROM, str(full_from)]
    return subprocess.run(
        [sys.executable, *begin, *map(str, words)], capture_output=True, text=True
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "writes", [1, 8, 26, *(pytest.param(n, marks=pytest.mark.soak) for n in (5, 7, 10, 15))]
)
def test_whichever_write_finds_no_room_nothing_is_lost_and_nothing_done_twice(
    tmp_path, bench, writes
):
    protocol = tmp_path / "full.yaml"
    protocol.write_text(PROTOCOL)
    runs = ["--runs", tmp_path / "runs"]
    ended = labrun("run", protocol, "--lab", bench.lab, *runs, full_from=writes)
    told = ended.stdout + ended.stderr

    assert ended.returncode == 1, told
    assert "No space left on device" in told
    assert "Traceback" not in told and "internal error" not in told

    folders = list((tmp_path / "runs").glob("*/journal.jsonl"))
    if not folders:
        return  # it never started, and nothing was sent
    run = folders[0].parent
    went_on = labrun("resume", "last", *runs)
    done = [c["name"] for c in bench.calls(run.name) if c["word"] == "done"]

    assert went_on.returncode == 0, went_on.stdout + went_on.stderr
    assert sorted(n for n in done if n.startswith("shot")) == [f"shot{i}" for i in range(4)]
    assert (run / "data.csv").read_text().splitlines()[1:] == [
        f"{i},{i},shot{i},succeeded" for i in range(4)
    ]
    assert list(read_records(run / "journal.jsonl"))[-1].fate == "succeeded"
