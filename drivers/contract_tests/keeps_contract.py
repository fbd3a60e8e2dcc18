"""One class that the tests of every driver inherit: real server, real sockets, real kills.

pytest is not needed to read it, only to run what inherits from it.
"""

from .calls import Calls
from .interruptions import Interruptions
from .kills import Kills


class KeepsContract(Calls, Interruptions, Kills):
    """Inherit, say what `case` is, and every promise of the contract is tried on a real server."""
