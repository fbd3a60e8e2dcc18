"""Rate and time left are those of the last points, not of the whole run."""

from io import StringIO

import pytest

from labrun.engine.progress import plain as plain_module
from labrun.engine.progress import progress as progress_module
from labrun.engine.progress.progress import Progress, ending_lines, harmless
from labrun.schemas.event import Event
from labrun.system.pace import rate_text


class Told:
    """A run of `total` points, told to a `Progress` by a clock of its own."""

    def __init__(self, monkeypatch, total):
        self.now, self.total, self.done = 0.0, total, 0
        monkeypatch.setattr(progress_module.time, "monotonic", lambda: self.now)
        self.progress = Progress()
        self.take = self.progress.take

    def points(self, count, seconds):
        for _ in range(count):
            self.tell("running")
            self.now += seconds
            self.done += 1
            self.tell("succeeded")
        return self.progress.loops["main/scan"]

    def tell(self, state):
        data = {"total": self.total, "done": self.done, "failed": 0, "key": str(self.done)}
        self.take(Event(event="iteration", path="main/scan", state=state, data=data))


def test_a_slow_beginning_does_not_spoil_the_time_left(monkeypatch):
    told = Told(monkeypatch, total=200)
    told.points(1, 60.0)

    loop = told.points(99, 1.0)

    assert loop.rate == 1.0
    assert loop.left_s == 100


def test_a_pause_is_no_slowness(monkeypatch):
    told = Told(monkeypatch, total=100)
    told.points(10, 1.0)
    told.progress.take(Event(event="control", state="pause"))
    told.now += 1000
    told.progress.take(Event(event="control", state="continue"))

    assert told.points(5, 1.0).rate == 1.0


def test_a_point_that_takes_longer_than_its_kind_slows_the_rate(monkeypatch):
    told = Told(monkeypatch, total=100)
    loop = told.points(10, 1.0)
    told.now += 11

    assert loop.rate == 0.5


@pytest.mark.parametrize(
    ("folder", "line"),
    [
        ("runs/2026-11-27_scan_abccf4ea", "labrun resume abccf4ea"),
        ("runs/my own run", 'labrun resume "my own run"'),
        ("/data/2026-11-27_scan_abccf4ea", "labrun resume /data/2026-11-27_scan_abccf4ea"),
    ],
)
def test_the_line_to_go_on_finds_the_run_from_here(folder, line):
    data = {"outputs": {}, "folder": folder, "holes": 0}
    name = folder.rpartition("/")[2]
    event = Event(event="finished", path=name, state="failed", data=data)

    assert ending_lines(event)[-1] == f"continue with: {line}"


def test_slow_rates_are_told_per_minute_or_hour():
    assert [rate_text(r) for r in (2.0, 0.1, 1 / 600)] == ["2.0/s", "6.0/min", "6.0/h"]


def test_no_rate_is_told_before_there_is_one(monkeypatch):
    told = Told(monkeypatch, total=9)
    monkeypatch.setattr(plain_module, "EVERY_S", -1.0)
    out = StringIO()
    watch = plain_module.PlainWatch(out)
    told.progress, told.take = watch.progress, watch
    told.tell("running")
    told.take(Event(event="goal", path="main/scan/0", state="sent", text="libs.measure"))
    told.points(4, 2.0)

    first, *_, last = out.getvalue().splitlines()
    assert first == "0/9 points (0 %), 0 failed; now libs.measure"
    assert last == "4/9 points (44 %), 0.5/s, 0:10 left, 0 failed; now libs.measure"


def test_what_a_terminal_obeys_is_shown_not_sent():
    assert harmless("50 µL\tok\n\x1b[2J\x07\u202e 👩‍🔬") == "50 µL\tok\n\\x1b[2J\\x07\\u202e 👩‍🔬"
