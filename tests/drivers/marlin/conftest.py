"""Marlins on pseudo-terminals, and drivers on them."""

from labrun.drivers.marlin.gantry import Marlin

from ..motion.fed import closed_at_end, on_a_peer
from .peer import Peer

peers = closed_at_end(Peer)
gantry = on_a_peer(lambda: Marlin, lambda peer: {"port": peer.path, "boot_s": 1})
