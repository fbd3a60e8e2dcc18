"""The class that every driver's tests inherit: real server, real sockets, real kills.

pytest is not needed to read it, only to run what inherits from it.
"""

from .calls import Calls
from .interruptions import Interruptions
from .kills import Kills


class KeepsContract(Calls, Interruptions, Kills):
    """Inherit, set `case`, and every promise of the contract is tested on a real server."""
