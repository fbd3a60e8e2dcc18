"""A thread works for an event loop: in order, each answer to who waits for it, all before it is closed."""

import asyncio
import threading

import pytest

from labrun.drivers.server.worker import Worker


def test_work_is_done_in_order_and_its_answers_and_faults_come_back():
    async def story():
        worker, done = Worker("worker"), []
        answers = [worker.do(done.append, 1), worker.do(int, "no number"), worker.do(len, done)]
        told = await asyncio.gather(*answers, return_exceptions=True)
        worker.close()
        return done, told

    done, (nothing, fault, length) = asyncio.run(story())

    assert (done, nothing, length) == ([1], None, 1)
    assert isinstance(fault, ValueError)


def test_what_is_cancelled_before_it_has_begun_is_left_out_and_the_rest_done_before_the_end():
    done, go = [], threading.Event()

    async def story():
        worker = Worker("worker")
        worker.do(go.wait, 20)
        worker.do(done.append, "cancelled").cancel()
        worker.do(done.append, "last")
        go.set()
        worker.close()
        with pytest.raises(RuntimeError, match="worker is closed"):
            worker.do(done.append, "too late")

    asyncio.run(story())

    assert done == ["last"]
