"""What the contract tests need to know about a driver: how to start it, and calls that work."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

from ...schemas.contract import Contract
from ...schemas.contracts import read_contract, shipped_contracts
from ...schemas.good_calls import good_call, lasting, slow_clock
from ...schemas.lab import Lab
from ..bridges.config import LAST_ONCE
from ..find import find_driver

Params = dict[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A driver as a lab names it, its configuration, and one valid call of each of its actions.

    Without a driver it is a device of a server that is no part of labrun.

    `contract` is the file of a contract that does not ship with labrun. `slow` is merged over
    `config` when an action has to be interrupted halfway: with it, every action that can be
    cancelled, every `once` action and the one named by `lasting` must take more than two seconds,
    except those in `quick`, which end at once (setting a zero) and are killed as they begin.
    `needs` lists what has to be done before a valid call succeeds (a tip, before anything is drawn
    into it), `files` what is sent with one, `bad` calls that must be refused in addition to those
    that follow from the schemas.
    """

    driver: str = ""
    good: dict[str, Params]
    lasting: str
    config: Params = field(default_factory=dict)
    slow: Params = field(default_factory=dict)
    limits: Params = field(default_factory=dict)
    contract: Path | Contract | None = None
    device: str = "device"
    needs: dict[str, list[str]] = field(default_factory=dict)
    files: dict[str, bytes] = field(default_factory=dict)
    bad: dict[str, list[Params]] = field(default_factory=dict)
    quick: frozenset[str] = frozenset()

    def read_contract(self) -> Contract:
        """The contract that the driver claims to keep."""
        if isinstance(self.contract, Contract):
            return self.contract
        if self.contract is not None:
            return read_contract(self.contract)
        return shipped_contracts()[find_driver(self.driver, Path()).contract]

    @classmethod
    def of_lab(cls, lab: Path, device: str) -> "Case":
        """The twin of a device whose bridge says its actions, with calls that its contract allows."""
        read = Lab.model_validate(YAML(typ="safe", pure=True).load(lab))
        entry = read.devices[device]
        files = (read_contract(lab.parent / file) for file in read.contracts)
        contract = next((one for one in files if one.type == entry.contract), None)
        if contract is None:
            model = find_driver(str(entry.driver), lab.parent).config_model  # type: ignore[attr-defined]
            made: Contract = model.model_validate(entry.config).contract(entry.contract)
            ships = shipped_contracts().get(str(entry.contract), made)
            contract = made if made.actions.keys() - ships.actions.keys() - {LAST_ONCE} else ships
        file, colon, name = str(entry.driver).rpartition(":")  # `./file.py:Class`, or a known name
        twin = f"Sim{name.removeprefix('Sim')}" if colon else f"sim_{name}"
        return cls(
            driver=f"{lab.parent / file}:{twin}" if colon else twin, config={**entry.config, "clock": "fast"},
            slow={"clock": slow_clock(contract)}, contract=contract, device=device,
            good={name: good_call(action) for name, action in contract.actions.items()},
            lasting=lasting(contract),
            files={name: b"190.0,1\n" for a in contract.actions.values() for name in a.path_params()[0]},
        )  # fmt: skip
