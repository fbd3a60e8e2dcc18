"""A GRBL controller to talk to, and drivers on its port."""

import asyncio

import pytest

from labrun.drivers.driver import GoalContext, Place
from labrun.drivers.grbl.gantry import Grbl

from .controllers import peer, peers

__all__ = ["peer", "peers"]


@pytest.fixture
def gantry(tmp_path):
    """A driver on a peer's port; `gantry(peer, home_first=True)`."""

    def make(peer, limits=None, **config):
        config = {"port": peer.path, **config}
        return Grbl(Place("gantry", config, limits or {}, tmp_path / "gantry", tmp_path))

    return make


@pytest.fixture
def played():
    """Open a driver, home it, let a story happen, close it; what the story returns."""

    def play(driver, story, *, homed=True):
        async def whole():
            await driver.open()
            try:
                if homed:
                    await driver.home(GoalContext("home"))
                return await story(driver)
            finally:
                await driver.close()

        return asyncio.run(whole())

    return play
