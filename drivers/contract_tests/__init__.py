"""The tests that every driver inherits: does it keep its contract, whatever happens?

from labrun.drivers.contract_tests import Case, KeepsContract

class TestFurnace(KeepsContract):
    case = Case(driver="./furnace.py:Furnace", ...)

`ServerKeepsContract` are the same tests for a device server that is written in another language.

Never need pytest, and never use a mock: real server, real sockets, real kills.
"""

from .case import Case
from .keeps_contract import KeepsContract, ServerKeepsContract

__all__ = ["Case", "KeepsContract", "ServerKeepsContract"]
