"""The tests that every driver inherits: does it keep its contract, whatever happens?

from labrun.drivers.contract_tests import Case, KeepsContract

class TestFurnace(KeepsContract):
    case = Case(driver="./furnace.py:Furnace", ...)

Never need pytest, and never use a mock: real server, real sockets, real kills.
"""

from .case import Case
from .keeps_contract import KeepsContract

__all__ = ["Case", "KeepsContract"]
