"""A driver that is asked as its server would ask it, and instruments that end with the test."""

import asyncio
from contextlib import ExitStack
from pathlib import Path

import pytest

from labrun.drivers.driver import GoalContext, Place
from labrun.drivers.find import find_driver

from .instruments import running_peer


@pytest.fixture
def peer(tmp_path):
    """Starts instruments that end with the test."""
    with ExitStack() as stack:
        yield lambda program="line_peer.py", name="peer", **habits: stack.enter_context(
            running_peer(tmp_path / name, program, **habits)
        )


@pytest.fixture
def ask(tmp_path):
    """Runs an async story with an opened driver: `ask("scpi", config, story)`."""

    def run(driver, config, story, *, opened=True):
        folder = tmp_path / "device"
        folder.mkdir(exist_ok=True)

        async def all_of_it():
            made = find_driver(driver, Path())(Place("dmm", config, {}, folder, tmp_path))
            async with asyncio.timeout(500):
                if opened:
                    await made.open()
                try:
                    return await story(made)
                finally:
                    await made.close()

        return asyncio.run(all_of_it())

    return run


@pytest.fixture
def once(ask):
    """Does one action with a fresh driver: `once("scpi", config, "voltage", range=1)`."""

    def run(driver, config, action, **values):
        async def story(made):
            return await made.method(action)(GoalContext("run/x/1"), **values)

        return ask(driver, config, story)

    return run
