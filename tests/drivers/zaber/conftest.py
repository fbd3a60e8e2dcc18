"""Chains of stages on pseudo-terminals, and drivers on them."""

from ..motion.fed import closed_at_end, on_a_peer
from .peer import Peer, config_of


def _zaber():
    from labrun.drivers.zaber.gantry import Zaber  # the maker's library may not be there

    return Zaber


peers = closed_at_end(Peer)
gantry = on_a_peer(_zaber, config_of)
