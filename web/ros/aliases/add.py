"""Add the names in a lab's `ros: aliases:` to its offers."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from ....engine.lab.lab import LoadedLab
from ....engine.language.suggest import did_you_mean, listed
from ..interfaces.fault import RosFault
from ..interfaces.names import TOPIC
from ..offers.device_action import DeviceAction
from . import gantry_status, launch, z300_status
from .analyze_spectrum import AnalyzeSpectrum
from .detect_samples import DetectSamples
from .export_spectrum import ExportSpectrum
from .is_gantry_rdy import IsReady
from .move_gantry import MoveGantry
from .paper import Paper
from .set_zero import SetZero
from .take_measurement import TakeMeasurement

if TYPE_CHECKING:
    from ..offers.offered_lab import OfferedLab

PAPER: dict[str, tuple[str, Callable[[Paper, str, str], None]]] = {
    "/move_gantry": ("gantry@1", MoveGantry.add),
    "/gantry_status": ("gantry@1", gantry_status.add),
    "/set_zero": ("gantry@1", SetZero.add),
    "/take_measurement": ("libs_analyzer@1", TakeMeasurement.add),
    "/export_spectrum": ("libs_analyzer@1", ExportSpectrum.add),
    "/analyze_spectrum": ("spectrum_reducer@1", AnalyzeSpectrum.add),
    "/is_gantry_rdy": ("gantry@1", IsReady.add),
    "/is_analytical_dev_rdy": ("libs_analyzer@1", IsReady.add),
    "/z300_status": ("libs_analyzer@1", z300_status.add),
    "/detect_samples": ("depth_camera@1", DetectSamples.add),
}
"""Name -> the contract of the device that it needs, and what offers it."""


def add_aliases(offered: "OfferedLab", lab: LoadedLab) -> Paper:
    """Add the names in the lab's `ros`; raises RosFault if one is wrong."""
    paper, names = Paper(offered), lab.lab.ros
    if names is None:
        return paper
    for name, target in names.aliases.items():
        if not TOPIC.match(name):
            raise RosFault(
                f"ros.aliases: {name!r} is not a valid ROS name; write it as `/move_gantry`, with "
                "letters, digits and single underscores"
            )
        if name in {**offered.offers.actions, **offered.offers.services, **offered.offers.topics}:
            raise RosFault(f"ros.aliases: {name} is already in use")
        if name in PAPER:
            contract, add = PAPER[name]
            add(paper, name, _device(offered, name, target, contract))
        else:
            _add_plain(offered, name, target)
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


def _add_plain(offered: "OfferedLab", name: str, target: str) -> None:
    device, dot, action = target.partition(".")
    if (
        not dot
        or device not in offered.devices
        or action not in offered.devices[device].contract.actions
    ):
        raise RosFault(
            f"ros.aliases: {name}: {target!r} is not a `device.action` of this lab"
            f"{did_you_mean(name, PAPER, prefix='the name ')}; names of the paper are {listed(PAPER)}"
        )
    found = offered.actions_of(device)[action]
    offered.offers.actions[name] = DeviceAction(
        name, found.kind, offered.devices[device], action, offered.folders.files
    )
