"""The progress of a batch tells the rate of the last minute; compiling before the first does not count."""

import time
from types import SimpleNamespace

import pytest

from labrun.reduction.commands.progress import Shown


@pytest.fixture
def at(monkeypatch):
    """Sets the clock."""
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    return lambda seconds: now.__setitem__(0, 100.0 + seconds)


def take(shown, number):
    for _ in range(number):
        shown.take(SimpleNamespace(reason=""))


def test_the_first_chunk_after_compiling_says_nothing_of_the_rate(at, capfd):
    shown = Shown()
    shown.expect(100)
    at(90)
    take(shown, 8)
    at(94)
    take(shown, 8)

    assert shown.waited_s == 90
    assert capfd.readouterr().err.splitlines() == ["labrun: 1/100 spectra"]
    assert shown.pace() == "2.0/s, 0:42 left"


def test_the_rate_is_that_of_the_last_minute(at):
    shown = Shown()
    shown.expect(1000)
    for second in range(100):  # slow
        at(10 * second)
        take(shown, 1)
    slow = shown.pace()
    for second in range(61):  # quick
        at(1000 + second)
        take(shown, 5)

    assert slow == "6.0/min, 2:30:00 left"
    assert shown.pace() == "5.0/s, 1:59 left"
