"""Names of the lab's `ros: aliases:`: the paper's own with its types, and any other for one action."""

from typing import TYPE_CHECKING

from ....engine.lab import LoadedLab
from ....engine.language.suggest import did_you_mean, listed
from ..device_action import DeviceAction
from ..fault import RosFault
from ..names import TOPIC
from . import (
    analyze_spectrum,
    export_spectrum,
    gantry_status,
    launch,
    move_gantry,
    set_zero,
    take_measurement,
)
from .paper import Paper

if TYPE_CHECKING:
    from ..site import Site

PAPER = (
    move_gantry, gantry_status, set_zero, take_measurement, export_spectrum, analyze_spectrum,
)  # fmt: skip
"""Each has its NAME, the CONTRACT of the device that it needs, and `add`."""


def add_aliases(site: "Site", lab: LoadedLab) -> None:
    """Add what the lab's `ros` names; raises RosFault with what is wrong there."""
    names = lab.lab.ros
    if names is None:
        return
    paper = Paper(site)
    known = {module.NAME: module for module in PAPER}
    for name, target in names.aliases.items():
        if not TOPIC.match(name):
            raise RosFault(
                f"ros.aliases: {name!r} is no name for ROS; it is written as `/move_gantry`, with "
                "letters, digits and single underscores"
            )
        if name in {**site.offers.actions, **site.offers.services, **site.offers.topics}:
            raise RosFault(f"ros.aliases: {name} is taken already")
        if name in known:
            known[name].add(paper, name, _device(site, name, target, known[name].CONTRACT))
        else:
            _add_plain(site, name, target, known)
    launch.add(paper, names.launch, lab)


def _device(site: "Site", name: str, device: str, contract: str) -> str:
    if device not in site.devices:
        hint = did_you_mean(device, site.devices)
        raise RosFault(
            f"ros.aliases: {name}: there is no device {device}{hint}; there are {listed(site.devices)}"
        )
    kept = site.devices[device].contract.type
    if kept != contract:
        raise RosFault(f"ros.aliases: {name} needs a {contract}, and {device} is a {kept}")
    return device


def _add_plain(site: "Site", name: str, target: str, known: dict) -> None:
    device, dot, action = target.partition(".")
    if not dot or device not in site.devices or action not in site.devices[device].contract.actions:
        raise RosFault(
            f"ros.aliases: {name}: {target!r} is no `device.action` of this lab"
            f"{did_you_mean(name, known, prefix='the name ')}; names of the paper are {listed(known)}"
        )
    found = site.actions_of(device)[action]
    site.offers.actions[name] = DeviceAction(
        name, found.kind, site.devices[device], action, site.folders.files
    )
