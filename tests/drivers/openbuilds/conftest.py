"""OpenBuilds CONTROL in front of a GRBL peer, and a driver that talks to it."""

import asyncio
import importlib.util
import sys
from pathlib import Path

import pytest

from labrun.drivers.driver import GoalContext, Place
from labrun.drivers.openbuilds import control as source
from labrun.drivers.openbuilds.gantry import OpenBuilds


def load(path):
    """A file of the tests, which are no package."""
    spec = importlib.util.spec_from_file_location(f"openbuilds_{path.stem}", path)
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


HERE = Path(__file__).parent
Peer = load(HERE.parent / "grbl" / "peer.py").Peer
Control = load(HERE / "control.py").Control


@pytest.fixture(autouse=True)
def soon(monkeypatch):
    """This CONTROL is never later than its 0.2 s and 0.1 s; the real one was by up to 0.9 s."""
    monkeypatch.setattr(source, "SETTLE_S", 0.5)


@pytest.fixture
def peers():
    """Makes GRBL controllers; `peers(speed=4)`."""
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
def program():
    """Makes a CONTROL in front of a peer, to be entered in the running loop."""
    return Control


@pytest.fixture
def gantry(tmp_path):
    """A driver; `gantry(url, "/dev/ttyUSB0", home_first=True)`."""

    def make(url, port, **config):
        config = {"url": url, "port": port, **config}
        return OpenBuilds(Place("gantry", config, {}, tmp_path / "gantry", tmp_path))

    return make


@pytest.fixture
def played(program, gantry):
    """CONTROL started, a driver opened and homed, a story, all closed; what the story returns."""

    def play(peer, story, *, homed=True, **config):
        async def whole():
            async with program(peer) as control:
                driver = gantry(control.url, peer.path, **config)
                await driver.open()
                try:
                    if homed:
                        await driver.home(GoalContext("home"))
                    return await story(driver, control)
                finally:
                    await driver.close()

        return asyncio.run(whole())

    return play
