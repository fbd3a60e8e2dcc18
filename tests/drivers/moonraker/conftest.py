"""Moonrakers with a Klipper behind them, and drivers on them."""

from labrun.drivers.moonraker.gantry import Moonraker

from ..motion.fed import closed_at_end, on_a_peer
from .peer import Peer

peers = closed_at_end(Peer)
gantry = on_a_peer(lambda: Moonraker, lambda peer: {"url": peer.url})
