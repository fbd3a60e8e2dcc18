"""Hours pass in an instant, in the right order, and nothing is waited for twice."""

import asyncio
import threading
import time

import pytest

from labrun.engine.run.virtual_time import StandsStill, VirtualLoop


def played(story, loop_factory=VirtualLoop):
    with asyncio.Runner(loop_factory=loop_factory) as runner:
        return runner.run(story())


def test_an_hour_of_sleep_is_over_at_once_and_the_clock_says_so():
    async def story():
        await asyncio.sleep(3600)
        return asyncio.get_running_loop().time()

    began = time.monotonic()

    assert played(story) == pytest.approx(3600)
    assert time.monotonic() - began < 60


def test_things_happen_in_the_order_of_their_times():
    seen = []

    async def after(seconds, name):
        await asyncio.sleep(seconds)
        seen.append(name)

    async def story():
        await asyncio.gather(after(30, "third"), after(10, "first"), after(20, "second"))

    played(story)

    assert seen == ["first", "second", "third"]


def test_a_timeout_comes_at_its_virtual_time():
    async def story():
        loop = asyncio.get_running_loop()
        try:
            async with asyncio.timeout(120):
                await asyncio.Event().wait()
        except TimeoutError:
            return loop.time()

    assert played(story) == pytest.approx(120)


def test_while_time_is_held_a_thread_is_waited_for_and_no_time_passes():
    async def story():
        loop = asyncio.get_running_loop()
        gate = threading.Event()
        timer = asyncio.create_task(asyncio.sleep(50))
        threading.Timer(0.05, gate.set).start()
        with loop.held():
            await asyncio.to_thread(gate.wait)
            during = loop.time()
        await timer
        return during, loop.time()

    during, after = played(story)

    assert during == 0
    assert after == pytest.approx(50)


def test_what_would_wait_for_ever_is_said():
    async def story():
        await asyncio.Event().wait()

    with pytest.raises(StandsStill, match="never comes"):
        played(story, lambda: VirtualLoop(longest_real_s=0.05))
