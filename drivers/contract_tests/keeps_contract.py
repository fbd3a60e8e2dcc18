"""The classes that every driver's tests inherit: real server, real sockets, real kills.

pytest is not needed to read them, only to run what inherits from them.
"""

from .calls import Calls
from .elsewhere import Elsewhere
from .interruptions import Interruptions
from .kills import Kills


class KeepsContract(Calls, Interruptions, Kills):
    """Inherit, set `case`, and every promise of the contract is tested on a real server."""


class ServerKeepsContract(Elsewhere, KeepsContract):
    """The same over the wire alone, for a device server in another language: set `command`, too."""
