"""Moonrakers with a Klipper behind them, each closed at its end, and drivers on them."""

import pytest

from labrun.drivers.driver import Place
from labrun.drivers.moonraker.gantry import Moonraker
from labrun.schemas.contracts import shipped_contracts

from .peer import Peer


@pytest.fixture
def peers():
    """Makes Moonrakers; `peers(speed=40)`."""
    made = []

    def make(**options):
        made.append(Peer(**options))
        return made[-1]

    yield make
    for peer in made:
        peer.close()


@pytest.fixture
def gantry(tmp_path):
    """A driver on a peer; `gantry(peer, home_first=True)`."""

    def make(peer, **config):
        contract = shipped_contracts()["gantry@2"]
        config = {"url": peer.url, **config}
        return Moonraker(Place("gantry", config, {}, tmp_path / "gantry", tmp_path, contract))

    return make
