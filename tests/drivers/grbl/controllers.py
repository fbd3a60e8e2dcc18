"""GRBL controllers for a test, each closed at its end."""

import pytest

from .peer import Peer


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
