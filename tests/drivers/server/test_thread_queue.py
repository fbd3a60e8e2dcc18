"""A thread works for an event loop: in order, each answer to who waits for it, all before it is closed."""

import asyncio
import threading

import pytest

from labrun.drivers.server.thread_queue import ThreadQueue


def test_work_is_done_in_order_and_its_answers_and_faults_come_back():
    async def story():
        queue, done = ThreadQueue("queue"), []
        answers = [queue.do(done.append, 1), queue.do(int, "no number"), queue.do(len, done)]
        told = await asyncio.gather(*answers, return_exceptions=True)
        queue.close()
        return done, told

    done, (nothing, fault, length) = asyncio.run(story())

    assert (done, nothing, length) == ([1], None, 1)
    assert isinstance(fault, ValueError)


def test_what_is_cancelled_before_it_has_begun_is_left_out_and_the_rest_done_before_the_end():
    done, go = [], threading.Event()

    async def story():
        queue = ThreadQueue("queue")
        slow = queue.do(go.wait, 20)
        assert not slow.done()
        queue.do(done.append, "cancelled").cancel()
        queue.do(done.append, "last")
        go.set()
        queue.close()
        with pytest.raises(RuntimeError, match="queue is closed"):
            queue.do(done.append, "too late")
        assert await slow

    asyncio.run(story())

    assert done == ["last"]
