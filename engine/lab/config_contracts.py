"""Contracts that a lab says in the `config` of its devices, and the problems in it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ...schemas.contract import Contract
from ...schemas.contracts import shipped_contracts
from ...schemas.lab import Lab, LabDevice
from ...schemas.problem import Problem
from ..language.shape import read_model
from ..language.source import Source
from ..language.suggest import closest, did_you_mean


def said_contracts(lab: Lab, contracts: dict[str, Contract], source: Source) -> Iterator[Problem]:
    """Add to `contracts` those that configs say; yield what is wrong in any config that says actions."""
    said: dict[str, tuple[str, Contract]] = {}
    for name, device in lab.devices.items():
        model = _config_model(device)
        if model is None:
            continue
        place = ("devices", name, "config")
        config, problems = read_model(
            model, device.config, source, place, f"the config of {device.driver}"
        )
        yield from problems
        if config is None:
            continue
        try:
            made = config.contract(device.contract)
        except ValidationError as fault:
            words = fault.errors()[0]["msg"]
            yield source.problem(place, "E132", f"config of {name}: {words}")
            continue
        first, other = said.get(device.contract, (name, made))
        if other != made:
            yield source.problem(
                ("devices", name), "E132",
                f"{name} and {first} are both {device.contract}, but say different actions",
                "give them the same actions, or each a contract of its own", key=True,
            )  # fmt: skip
        ships = shipped_contracts().get(device.contract)
        if ships is not None and contracts.get(device.contract) == ships and _own(made, ships):
            del contracts[device.contract]  # as a contract in a file of the lab's own comes first
        apart = device.contract in contracts and device.contract not in said
        kept = contracts.setdefault(device.contract, made)
        if not apart:
            said[device.contract] = (name, made)
        for fault in config.faults(kept, apart=apart and kept != made):
            guess = ""
            if fault.key and fault.path[:1] == ("actions",) and len(fault.path) == 2:
                guess = did_you_mean(str(fault.path[1]), kept.actions)
            yield source.problem(
                (*place, *fault.path), "E132", fault.message + guess, key=fault.key
            )


def _own(made: Contract, ships: Contract) -> bool:
    """True if a config says another contract than the one of that name which ships with labrun.

    It does as soon as it says an action that the other does not have, and that is no misspelling.
    """
    from ...drivers.bridges.config import LAST_ONCE

    missing = ships.actions.keys() - made.actions.keys()
    others = made.actions.keys() - ships.actions.keys() - {LAST_ONCE}
    return any(closest(name, missing) is None for name in others)


def broken(name: str, device: LabDevice, source: Source) -> bool:
    """True if the device's config should say its contract, but cannot be read."""
    model = _config_model(device)
    if model is None:
        return False
    return read_model(model, device.config, source, ("devices", name, "config"), "")[0] is None


def _config_model(device: LabDevice) -> Any:
    """How the config of a driver that ships is read, if that driver says so."""
    if "actions" not in device.config:
        return None
    from ...drivers.find import SHIPPED, DriverFault, find_driver  # asyncio, with all it needs

    if device.driver not in SHIPPED:
        return None
    try:
        return getattr(find_driver(device.driver, Path()), "config_model", None)
    except DriverFault:
        return None
