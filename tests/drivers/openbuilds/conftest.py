"""OpenBuilds CONTROL in front of a GRBL peer, and a driver that talks to it."""

import asyncio

import pytest

from labrun.drivers.driver import GoalContext, Place
from labrun.drivers.openbuilds import control as source
from labrun.drivers.openbuilds import stopping
from labrun.drivers.openbuilds.gantry import OpenBuilds

from ..grbl.controllers import peer, peers
from .control import Control

__all__ = ["peer", "peers"]


@pytest.fixture(autouse=True)
def soon(monkeypatch):
    """This CONTROL is never later than its 0.2 s and 0.1 s; the real one was by up to 0.9 s."""
    monkeypatch.setattr(source, "SETTLE_S", 0.5)
    monkeypatch.setattr(
        stopping, "HOLD_S", 60
    )  # it always brakes, and answers: when, is the machine's
    monkeypatch.setattr(stopping, "PROOF_S", 60)


@pytest.fixture
def program():
    """Makes a CONTROL in front of a peer, to be entered in the running loop."""
    return Control


@pytest.fixture
def gantry(tmp_path):
    """A driver; `gantry(url, "/dev/ttyUSB0", home_first=True)`."""

    def make(url, port, **config):
        config = {"url": url, "port": port, "silence_s": 30, **config}
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
