"""Seconds are slept on the real clock and counted on both."""

import asyncio

import pytest

from labrun.drivers.simulated.twins.clock import Clock
from labrun.engine.run.virtual_time import VirtualLoop


def test_the_fast_clock_counts_an_hour_and_lets_others_have_their_turn():
    clock, seen = Clock("fast"), []

    async def other():
        seen.append(clock.elapsed_s)

    async def play():
        task = asyncio.create_task(other())
        await clock.sleep(3600)
        await task

    asyncio.run(play())

    assert clock.elapsed_s == 3600
    assert seen == [0.0]


def test_the_real_clock_counts_what_it_slept():
    clock = Clock("real")
    asyncio.run(clock.sleep(0.01))

    assert clock.elapsed_s == 0.01


def test_a_clock_that_runs_faster_counts_the_seconds_of_the_real_one():
    clock = Clock(10_000)
    asyncio.run(clock.sleep(100))

    assert clock.elapsed_s == 100


@pytest.mark.parametrize("kind", ["real", "fast", 1e6])
def test_a_sleep_ends_when_it_is_told_to(kind):
    async def play():
        clock, stop = Clock(kind), asyncio.Event()
        slept = await clock.sleep_unless(stop, 0.01)
        stop.set()
        return slept, await clock.sleep_unless(stop, 3600)

    assert asyncio.run(play()) == (False, True)


@pytest.mark.parametrize("kind", ["fast", "rehearsal"])
def test_a_sleep_takes_time_though_it_is_shorter_than_the_clock_can_tell(kind):
    async def play():
        clock = Clock(kind)
        await clock.sleep(40_000)
        await clock.sleep_unless(asyncio.Event(), 1e-12)
        return clock.now_s()

    with asyncio.Runner(loop_factory=VirtualLoop) as runner:
        assert runner.run(play()) > 40_000


def test_there_is_no_third_clock():
    with pytest.raises(ValueError, match="clock is 'slow'; it must be real, fast"):
        Clock("slow")
