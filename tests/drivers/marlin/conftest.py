"""Marlins on pseudo-terminals, each closed at its end, and drivers on them."""

import pytest

from labrun.drivers.driver import Place
from labrun.drivers.marlin.gantry import Marlin
from labrun.schemas.contracts import shipped_contracts

from .peer import Peer


@pytest.fixture
def peers():
    """Makes Marlins; `peers(emergency=False)`."""
    made = []

    def make(**options):
        made.append(Peer(**options))
        return made[-1]

    yield make
    for peer in made:
        peer.close()


@pytest.fixture
def gantry(tmp_path):
    """A driver on a peer's port; `gantry(peer, home_first=True)`."""

    def make(peer, **config):
        config = {"port": peer.path, "boot_s": 1, **config}
        contract = shipped_contracts()["gantry@2"]
        return Marlin(Place("gantry", config, {}, tmp_path / "gantry", tmp_path, contract))

    return make
