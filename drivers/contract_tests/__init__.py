"""The tests that every driver inherits: does it keep its contract, whatever happens to it?

from labrun.drivers.contract_tests import Case, KeepsContract

class TestFurnace(KeepsContract):
    case = Case(driver="./furnace.py:Furnace", ...)
"""

from .case import Case
from .keeps_contract import KeepsContract

__all__ = ["Case", "KeepsContract"]
