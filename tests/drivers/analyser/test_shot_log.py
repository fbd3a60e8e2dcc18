"""The shot log outlives a kill, and no goal is in it twice."""

import os
import signal
import subprocess
import sys

import pytest

from labrun.drivers.analyser.shot_log import AlreadyBegun, ShotLog


@pytest.fixture
def shot_log(tmp_path):
    opened = ShotLog(tmp_path / "shots.sqlite")
    yield opened
    opened.close()


def test_shots_are_numbered_and_told_by_name(shot_log):
    first, second = (shot_log.begin(goal, 1.0, {"a"}) for goal in ("g1", "g2"))
    shot_log.fired(first, "entry")

    assert (first.name, second.name) == ("shot-000001", "shot-000002")
    assert (shot_log.shot("shot-000001").fate, shot_log.shot("shot-000001").entry) == (
        "fired",
        "entry",
    )
    assert [shot_log.shot(name) for name in ("shot-3", "shot-1", "1", "shot-²")] == [None] * 4
    assert shot_log.count() == 1


def test_a_goal_is_begun_once(shot_log):
    shot_log.begin("g", 1.0, None)

    with pytest.raises(AlreadyBegun, match="it is not repeated"):
        shot_log.begin("g", 2.0, None)


def test_what_surely_did_not_happen_hides_nothing(shot_log):
    fired = shot_log.begin("g1", 1.0, set())
    shot_log.fired(fired, None)
    shot_log.denied(shot_log.begin("g2", 2.0, set()))

    assert shot_log.newest().goal == "g1"


def test_a_shot_that_was_begun_is_there_after_a_kill(tmp_path):
    script = f"""
import pathlib, time
from labrun.drivers.analyser.shot_log import ShotLog
ShotLog(pathlib.Path({str(tmp_path)!r}) / "shots.sqlite").begin("g", 1.0, ["x", "y"])
print("begun", flush=True)
time.sleep(60)
"""
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        os.kill(process.pid, signal.SIGKILL)
    shot_log = ShotLog(tmp_path / "shots.sqlite")
    newest = shot_log.newest()
    shot_log.close()

    assert (newest.goal, newest.fate, newest.before) == ("g", "begun", frozenset({"x", "y"}))


def test_a_book_that_is_none_is_told(tmp_path):
    (tmp_path / "shots.sqlite").write_text("not a database, but long enough to be read as one" * 9)

    with pytest.raises(OSError, match=r"the shot log .* cannot be opened"):
        ShotLog(tmp_path / "shots.sqlite")
