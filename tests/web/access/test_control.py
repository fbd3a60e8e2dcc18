"""Control of the bench: who was idle for too long has lost it, whatever a clock on the wall says."""

import time

from labrun.web.access.control import Control


def test_a_clock_that_is_set_takes_control_from_nobody(monkeypatch):
    told = []
    control = Control(lambda: None, lambda: False, told.append)
    lease = control.take("Ada", "", None).lease
    ahead = time.time() + 3600
    monkeypatch.setattr(time, "time", lambda: ahead)

    assert control.used_by(lease) == "Ada" and told == []


def test_control_is_free_after_five_idle_minutes(monkeypatch):
    told = []
    control = Control(lambda: None, lambda: False, told.append)
    lease = control.take("Ada", "", None).lease
    later = time.monotonic() + 301
    monkeypatch.setattr(time, "monotonic", lambda: later)

    assert control.state().holder is None
    assert told == ["Ada was idle; control is free"]
    assert control.take("Bob", "", lease).control.holder == "Bob"
