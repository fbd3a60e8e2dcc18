"""The book of shots outlives a kill, and no goal stands in it twice."""

import os
import signal
import subprocess
import sys

import pytest

from labrun.drivers.analyser.book import AlreadyBegun, ShotBook


@pytest.fixture
def book(tmp_path):
    opened = ShotBook(tmp_path / "shots.sqlite")
    yield opened
    opened.close()


def test_shots_are_numbered_and_told_by_name(book):
    first, second = (book.begin(goal, 1.0, {"a"}) for goal in ("g1", "g2"))
    book.fired(first, "entry")

    assert (first.name, second.name) == ("shot-000001", "shot-000002")
    assert (book.shot("shot-000001").fate, book.shot("shot-000001").entry) == ("fired", "entry")
    assert [book.shot(name) for name in ("shot-3", "shot-1", "1", "shot-²")] == [None] * 4
    assert book.count() == 1


def test_a_goal_is_begun_once(book):
    book.begin("g", 1.0, None)

    with pytest.raises(AlreadyBegun, match="it is not made again"):
        book.begin("g", 2.0, None)


def test_what_surely_did_not_happen_hides_nothing(book):
    fired = book.begin("g1", 1.0, set())
    book.fired(fired, None)
    book.denied(book.begin("g2", 2.0, set()))

    assert book.newest().goal == "g1"


def test_a_shot_that_was_begun_is_there_after_a_kill(tmp_path):
    script = f"""
import pathlib, time
from labrun.drivers.analyser.book import ShotBook
ShotBook(pathlib.Path({str(tmp_path)!r}) / "shots.sqlite").begin("g", 1.0, ["x", "y"])
print("begun", flush=True)
time.sleep(60)
"""
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        os.kill(process.pid, signal.SIGKILL)
    book = ShotBook(tmp_path / "shots.sqlite")
    newest = book.newest()
    book.close()

    assert (newest.goal, newest.fate, newest.before) == ("g", "begun", frozenset({"x", "y"}))


def test_a_book_that_is_none_is_told(tmp_path):
    (tmp_path / "shots.sqlite").write_text("not a database, but long enough to be read as one" * 9)

    with pytest.raises(OSError, match=r"the book of shots .* cannot be opened"):
        ShotBook(tmp_path / "shots.sqlite")
