"""Control of the bench: who was idle for too long has lost it, whatever a clock on the wall says."""

import time

import pytest

from labrun.web.access.control import Control
from labrun.web.local.refusal import Refusal


def test_a_clock_that_is_set_takes_control_from_nobody(monkeypatch):
    told = []
    control = Control(lambda: None, lambda: False, lambda *said: told.append(said))
    lease = control.take("Ada", "", None).lease
    ahead = time.time() + 3600
    monkeypatch.setattr(time, "time", lambda: ahead)

    assert control.used_by(lease) == "Ada" and told == []


def test_control_is_free_after_five_idle_minutes(monkeypatch):
    told = []
    control = Control(lambda: None, lambda: False, lambda *said: told.append(said))
    lease = control.take("Ada", "", None).lease
    later = time.monotonic() + 301
    monkeypatch.setattr(time, "monotonic", lambda: later)

    assert control.state().holder is None
    assert told == [("Ada was idle; control is free", "info")]
    assert control.take("Bob", "", lease).control.holder == "Bob"


def test_the_same_person_in_a_second_browser_takes_control_at_once():
    told = []
    control = Control(lambda: None, lambda: False, lambda *said: told.append(said))
    first = control.take("Ada", "", None).lease
    second = control.take("ada", "", None).lease

    assert control.used_by(second) == "ada"
    assert told == [("ada has control in another browser now", "info")]
    with pytest.raises(Refusal, match="ada has control"):
        control.used_by(first)
    with pytest.raises(Refusal, match="ada has control"):
        control.take("Bob", "", None)
