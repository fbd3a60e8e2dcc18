"""A GRBL controller to talk to, and drivers on its port."""

import asyncio
import importlib.util
import sys
from pathlib import Path

import pytest

from labrun.drivers.driver import GoalContext, Place
from labrun.drivers.grbl.gantry import Grbl


def load(name):
    """A file beside this one: tests are no package."""
    spec = importlib.util.spec_from_file_location(
        f"grbl_{name}", Path(__file__).with_name(f"{name}.py")
    )
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


Peer = load("peer").Peer


@pytest.fixture
def peers():
    """Makes controllers; `peers(hal=True)`."""
    made = []

    def make(**options):
        made.append(Peer(**options))
        return made[-1]

    yield make
    for peer in made:
        peer.close()


@pytest.fixture
def peer(peers):
    return peers()


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
