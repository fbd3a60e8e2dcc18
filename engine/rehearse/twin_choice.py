"""What plays each device in a rehearsal: the lab's own twins, twins of its contracts, or stand-ins."""

import asyncio
import json
from copy import deepcopy
from pathlib import Path
from typing import Any

from ...drivers.driver import Driver, GoalContext
from ...drivers.find import (
    SHIPPED,
    DriverFault,
    check_installed,
    driver_places,
    find_driver,
    speaks,
)
from ...drivers.simulated.twins.twin import Twin
from ...drivers.world import WorldInMemory
from ...schemas.contract import Contract
from ...schemas.lab import LabDevice
from ...schemas.messages import FileContent
from ...schemas.plainest import plainest
from ..lab.lab import LoadedLab

COMPUTING = {"reducer": "the reduction itself", "gp": "the optimizer itself"}
"""Drivers that move nothing: in a rehearsal they do what they always do."""


def player(name: str, lab: LoadedLab) -> tuple[type[Driver], dict[str, Any], str]:
    """Driver class, its configuration, and a note on what plays this device."""
    device = lab.lab.devices[name]
    contract = lab.contracts[device.contract]
    own = _own(device, lab)
    if own is not None and issubclass(own, Twin):
        return own, {**device.config, "clock": "rehearsal"}, f"its own twin, {device.driver}"
    if own is not None and device.driver in COMPUTING:
        return own, {}, COMPUTING[device.driver]
    for known in sorted(driver_places()):
        if known in SHIPPED and known not in COMPUTING and not known.startswith("sim_"):
            continue  # of real hardware; it need not be imported to know that
        found = _found(known)
        if found is None or not speaks(found, contract) or not _does(found, contract):
            continue
        if issubclass(found, Twin):
            return found, _configured(found, lab), f"the twin {known}"
        if known in COMPUTING:
            return found, {}, COMPUTING[known]
    return stand_in(contract), {}, f"a stand-in: no twin keeps {contract.type}"


def _own(device: LabDevice, lab: LoadedLab) -> type[Driver] | None:
    if device.driver is None:
        return None
    try:
        found = find_driver(device.driver, lab.path.parent if lab.path else Path())
        check_installed(found, device.config)
        return found
    except DriverFault:
        return None  # not installed here: a rehearsal can do without it


def _found(name: str) -> type[Driver] | None:
    try:
        found = find_driver(name, Path())
        check_installed(found, {})
        return found
    except DriverFault:
        return None


def _does(driver: type[Driver], contract: Contract) -> bool:
    """False where a lab's own contract has the name of one that ships, and other actions."""
    return all(hasattr(driver, action) for action in contract.actions)


def _configured(twin: type[Twin], lab: LoadedLab) -> dict[str, Any]:
    """Twins name the devices that they work with (`gantry`): here, the lab's first of that kind."""
    kinds: dict[str, str] = {}
    for name, device in lab.lab.devices.items():
        kinds.setdefault(device.contract.partition("@")[0], name)
    return {"clock": "rehearsal"} | {kind: kinds[kind] for kind in twin.options if kind in kinds}


def files_made(world: WorldInMemory, files: dict[str, FileContent]) -> dict[str, FileContent]:
    """Files with what they hold."""
    return {
        name: one if world.is_made(one.data) else FileContent.of(one.path, world.made(one.data))
        for name, one in files.items()
    }


def may_repeat(played_by: str, contract: Contract) -> bool:
    """Whether a device does what it always does, and that changes nothing."""
    pure = all(action.effect == "pure" for action in contract.actions.values())
    return pure and played_by in COMPUTING.values()


def repeating(driver: type[Driver], contract: Contract, world: WorldInMemory) -> type[Driver]:
    """A driver that computes one answer for all goals of a kind, and gives it again, at once.

    They differ only in files whose content nothing has asked for yet, so that what is wrong with
    arguments, or with a file that is there, is found as ever.
    """
    answers: dict[str, dict[str, Any]] = {}

    def action(name: str):
        computed = getattr(driver, name)

        async def perform(self: Driver, goal: GoalContext, **params: Any) -> dict[str, Any]:
            of = {n: f.sha256 * world.is_made(f.data) for n, f in goal.files.items()}
            kind = json.dumps([name, params | of], sort_keys=True)
            if kind not in answers:
                goal.files = files_made(world, goal.files)
                answers[kind] = await computed(self, goal, **params)
            return deepcopy(answers[kind])

        return perform

    methods = {name: action(name) for name in contract.actions}
    return type(driver.__name__, (driver,), methods)


def stand_in(contract: Contract) -> type[Driver]:
    """A driver that takes the typical time and answers with the simplest values allowed."""

    def action(name: str):
        wanted = contract.actions[name]

        async def perform(self: Driver, goal: GoalContext, **params: Any) -> dict[str, Any]:
            await asyncio.sleep(wanted.typical_s(params) or 0.0)
            result = {}
            for field, schema in wanted.returns.get("properties", {}).items():
                result[field] = plainest(schema, params.get(field))
                if schema.get("format") == "path":
                    empty = FileContent.of(str(result[field]), b"")
                    goal.files[field] = empty
            return result

        return perform

    methods = {name: action(name) for name in contract.actions}
    return type("StandIn", (Driver,), {"contract": contract.type, **methods})
