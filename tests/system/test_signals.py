"""A signal that asks a process to end is told to its loop; one that it was told to ignore is not."""

import asyncio
import signal

import pytest

from labrun.system.signals import on_end, until_end

POSIX = pytest.mark.posix("it knows no SIGHUP")
THERE = ["SIGINT", "SIGTERM", *(["SIGHUP"] if hasattr(signal, "SIGHUP") else [])]


@pytest.fixture(autouse=True)
def former_handlers():
    before = {name: signal.getsignal(getattr(signal, name)) for name in THERE}
    for name in THERE:  # `nohup` has one of them ignored
        signal.signal(getattr(signal, name), signal.default_int_handler)
    yield
    for name, handler in before.items():
        signal.signal(getattr(signal, name), handler)


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", pytest.param("SIGHUP", marks=POSIX)])
def test_each_signal_is_told_by_the_name_that_a_person_knows(name):
    async def story():
        told = asyncio.get_running_loop().create_future()
        on_end(told.set_result)
        signal.raise_signal(getattr(signal, name))
        return await told

    assert asyncio.run(story()) == {"SIGINT": "Ctrl-C"}.get(name, name)


def test_the_former_handlers_are_restored():
    async def story():
        on_end(print)()

    before = signal.getsignal(signal.SIGTERM)
    asyncio.run(story())

    assert signal.getsignal(signal.SIGTERM) is before


@POSIX
def test_what_nohup_has_ignored_stays_ignored():
    signal.signal(signal.SIGHUP, signal.SIG_IGN)

    async def story():
        over = until_end()
        signal.raise_signal(signal.SIGHUP)
        await asyncio.sleep(0)
        heard = over.is_set()
        signal.raise_signal(signal.SIGTERM)
        await over.wait()
        return heard

    assert asyncio.run(story()) is False
    assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN


def test_a_signal_after_the_loop_has_ended_is_nobodys():
    async def story():
        on_end(print)

    asyncio.run(story())
    signal.raise_signal(signal.SIGTERM)  # and this process lives


def test_another_thread_hears_none():
    async def story():
        await asyncio.to_thread(asyncio.run, heard_there())

    async def heard_there():
        on_end(print)

    before = signal.getsignal(signal.SIGTERM)
    asyncio.run(story())

    assert signal.getsignal(signal.SIGTERM) is before
