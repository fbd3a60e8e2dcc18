"""A device's status is told as it is, and a driver that cannot say it does no harm."""

import asyncio

import pytest

from labrun.drivers.driver import Driver
from labrun.drivers.server.status import StatusWatch


def told(driver):
    async def story():
        heard = asyncio.Queue()
        watch = StatusWatch(driver, heard.put_nowait)
        await watch.open()
        first = watch.latest
        watch.changed()
        async with asyncio.timeout(500):
            second = await heard.get()
        await watch.close()
        return first, second

    return asyncio.run(story())


class Counting(Driver):
    def __init__(self):
        self.count = 0

    async def status(self):
        self.count += 1
        return {"count": self.count}


def test_a_change_is_told():
    assert told(Counting()) == ({"count": 1}, {"count": 2})


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (lambda: 1 / 0, "ZeroDivisionError: division by zero"),
        (
            lambda: {"level": float("nan")},
            "status.level: nan is not a number that JSON can represent",
        ),
        (lambda: {"level": b"7"}, "status.level: a bytes is not a JSON type"),
    ],
)
def test_a_status_that_cannot_be_had_is_told_as_a_fault(answer, words):
    class Broken(Counting):
        async def status(self):
            return answer()

    _, second = told(Broken())

    assert words in second["fault"]
