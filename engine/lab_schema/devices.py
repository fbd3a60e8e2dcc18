"""The shape of `devices`: the lab's devices are suggested as roles, with their contracts."""

from ...schemas.contract import Contract
from ..lab.lab import LoadedLab
from .models import NAME
from .values import Shape, names


def kept_contracts(lab: LoadedLab) -> dict[str, Contract]:
    """Contract type -> contract, for those that a device of this lab has."""
    types = dict.fromkeys(device.contract for device in lab.lab.devices.values())
    return {name: lab.contracts[name] for name in types}


def played_contracts(lab: LoadedLab) -> dict[str, Contract]:
    """Those that a role may need here: the devices' own, and the earlier ones that these keep."""
    kept = kept_contracts(lab)
    also = {name for contract in kept.values() for name in contract.also if name in lab.contracts}
    return kept | {name: lab.contracts[name] for name in sorted(also)}


def devices_shape(lab: LoadedLab) -> Shape:
    """Role -> contract; any name is accepted, and any contract of a device in this lab."""
    contracts = played_contracts(lab)
    each: Shape = {
        "enum": list(contracts),
        "enumDescriptions": [contract.summary for contract in contracts.values()],
        "errorMessage": f"No device of this lab has that contract; they have {', '.join(contracts)}.",
    }
    shape = names(NAME, 60, each)
    shape["properties"] = {
        name: {
            **each,
            "examples": [device.contract],
            "description": f"{lab.contracts[device.contract].summary}: {name} of this lab.",
        }
        for name, device in lab.lab.devices.items()
    }
    return shape
