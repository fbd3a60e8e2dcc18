"""What tests of every fed gantry begin with: peers that are closed at their end, and drivers on them."""

from collections.abc import Callable
from typing import Any

import pytest

from labrun.drivers.driver import Place
from labrun.schemas.contracts import shipped_contracts


def closed_at_end(peer: type) -> Any:
    """A fixture that makes peers; `peers(speed=100)`."""

    @pytest.fixture
    def peers():
        made = []

        def make(**options):
            made.append(peer(**options))
            return made[-1]

        yield make
        for one in made:
            one.close()

    return peers


def on_a_peer(driver: Callable[[], type], config_of: Callable[[Any], dict[str, Any]]) -> Any:
    """A fixture that makes drivers; `gantry(peer, home_first=True)`. The class is loaded when it is used."""

    @pytest.fixture
    def gantry(tmp_path):
        def make(peer, **config):
            contract = shipped_contracts()["gantry@2"]
            config = {**config_of(peer), **config}
            return driver()(Place("gantry", config, {}, tmp_path / "gantry", tmp_path, contract))

        return make

    return gantry
