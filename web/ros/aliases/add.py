"""Add the names in a lab's `ros: aliases:` to its offers."""

from typing import TYPE_CHECKING

from ....engine.lab.lab import LoadedLab
from ....engine.language.suggest import did_you_mean, listed
from ..interfaces.fault import RosFault
from ..interfaces.names import TOPIC
from ..offers.device_action import DeviceAction
from . import (
    analyze_spectrum,
    detect_samples,
    export_spectrum,
    gantry_status,
    is_analytical_dev_rdy,
    is_gantry_rdy,
    launch,
    move_gantry,
    set_zero,
    take_measurement,
    z300_status,
)
from .paper import Paper

if TYPE_CHECKING:
    from ..offers.offered_lab import OfferedLab

PAPER = (
    move_gantry, gantry_status, set_zero, take_measurement, export_spectrum, analyze_spectrum,
    is_gantry_rdy, is_analytical_dev_rdy, z300_status, detect_samples,
)  # fmt: skip
"""Each has its NAME, the CONTRACT of the device that it needs, and `add`."""


def add_aliases(offered: "OfferedLab", lab: LoadedLab) -> Paper:
    """Add the names in the lab's `ros`; raises RosFault if one is wrong."""
    paper, names = Paper(offered), lab.lab.ros
    if names is None:
        return paper
    known = {module.NAME: module for module in PAPER}
    for name, target in names.aliases.items():
        if not TOPIC.match(name):
            raise RosFault(
                f"ros.aliases: {name!r} is not a valid ROS name; write it as `/move_gantry`, with "
                "letters, digits and single underscores"
            )
        if name in {**offered.offers.actions, **offered.offers.services, **offered.offers.topics}:
            raise RosFault(f"ros.aliases: {name} is already in use")
        if name in known:
            known[name].add(paper, name, _device(offered, name, target, known[name].CONTRACT))
        else:
            _add_plain(offered, name, target, known)
    launch.add(paper, names.launch, lab)
    return paper


def _device(offered: "OfferedLab", name: str, device: str, contract: str) -> str:
    if device not in offered.devices:
        hint = did_you_mean(device, offered.devices)
        raise RosFault(
            f"ros.aliases: {name}: there is no device {device}{hint}; there are {listed(offered.devices)}"
        )
    kept = offered.devices[device].contract
    if not kept.keeps(contract):
        raise RosFault(f"ros.aliases: {name} needs a {contract}, and {device} is a {kept.type}")
    return device


def _add_plain(offered: "OfferedLab", name: str, target: str, known: dict) -> None:
    device, dot, action = target.partition(".")
    if (
        not dot
        or device not in offered.devices
        or action not in offered.devices[device].contract.actions
    ):
        raise RosFault(
            f"ros.aliases: {name}: {target!r} is not a `device.action` of this lab"
            f"{did_you_mean(name, known, prefix='the name ')}; names of the paper are {listed(known)}"
        )
    found = offered.actions_of(device)[action]
    offered.offers.actions[name] = DeviceAction(
        name, found.kind, offered.devices[device], action, offered.folders.files
    )
