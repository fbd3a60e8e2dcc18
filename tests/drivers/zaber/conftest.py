"""Chains of stages on pseudo-terminals, each closed at its end, and drivers on them."""

import pytest

from labrun.drivers.driver import Place
from labrun.schemas.contracts import shipped_contracts

from .peer import Peer, config_of


@pytest.fixture
def peers():
    """Makes chains; `peers(speed=100)`."""
    made = []

    def make(**options):
        made.append(Peer(**options))
        return made[-1]

    yield make
    for peer in made:
        peer.close()


@pytest.fixture
def gantry(tmp_path):
    """A driver on a chain's port; `gantry(peer, home_first=True)`."""
    from labrun.drivers.zaber.gantry import Zaber

    def make(peer, **config):
        contract = shipped_contracts()["gantry@2"]
        config = {**config_of(peer), **config}
        return Zaber(Place("gantry", config, {}, tmp_path / "gantry", tmp_path, contract))

    return make
