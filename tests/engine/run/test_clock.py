"""The run's own time, and what it makes of a computer whose clock is set meanwhile."""

from datetime import UTC, datetime, timedelta

import pytest

from labrun.engine.run.clock import RunClock

BEGAN = datetime(2026, 10, 25, 2, 30, tzinfo=UTC)


@pytest.mark.parametrize("by", [timedelta(hours=-1), timedelta(days=2)])
def test_a_clock_that_is_set_makes_no_time_pass(by):
    passed_s, set_by = [0.0], [timedelta()]
    clock = RunClock(
        time_of_day=lambda: BEGAN + timedelta(seconds=passed_s[0]) + set_by[0],
        steady=lambda: 7.0 + passed_s[0],
    )
    passed_s[0], set_by[0] = 90.0, by

    assert clock.since(BEGAN) == 90
    assert clock.since(BEGAN - timedelta(seconds=30)) == 120
    assert clock.time_of_day() == BEGAN + timedelta(seconds=90) + by

    clock.begin()
    assert clock.since(BEGAN) == (by + timedelta(seconds=90)).total_seconds()
