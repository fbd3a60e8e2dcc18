"""What the contract tests have to know of a driver: how it is started, and calls that work."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...schemas.contract import Contract
from ...schemas.contracts import read_contract, shipped_contracts
from ..find import find_driver

Params = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Case:
    """A driver as a lab names it, its configuration, and one good call of each of its actions.

    `contract` is the file of a contract that does not ship. `slow` is laid over `config` where an
    action has to be caught in the middle: there every action that can be cancelled, every one that
    is `once` and the one called `lasting` takes more than two seconds, but for those in `quick`,
    which are over at once (a zero that is set) and are killed as they begin. `needs` says what has
    to be done before a good call succeeds (a tip, before anything is drawn into it), `files` what
    comes along with one, `bad` which calls are to be refused beside those that follow from the
    schemas.
    """

    driver: str
    good: dict[str, Params]
    lasting: str
    config: Params = field(default_factory=dict)
    slow: Params = field(default_factory=dict)
    limits: Params = field(default_factory=dict)
    contract: Path | None = None
    device: str = "device"
    needs: dict[str, list[str]] = field(default_factory=dict)
    files: dict[str, bytes] = field(default_factory=dict)
    bad: dict[str, list[Params]] = field(default_factory=dict)
    quick: frozenset[str] = frozenset()

    def read_contract(self) -> Contract:
        """The contract that the driver says it keeps."""
        if self.contract is not None:
            return read_contract(self.contract)
        return shipped_contracts()[find_driver(self.driver, Path()).contract]
