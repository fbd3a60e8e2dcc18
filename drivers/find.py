"""Find a driver class by name or path, and reject one that does not keep its contract."""

import importlib
import importlib.util
import inspect
import sys
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path
from types import ModuleType
from typing import Any

from ..schemas.contract import Action, Contract
from ..schemas.contracts import shipped_contracts
from ..system.extras import OF_DRIVERS, in_words, not_installed
from .driver import Driver

BRIDGES = (
    "scpi",
    "text",
    "modbus",
    "http",
    "pymeasure",
    "qcodes",
    "ophyd",
    "pylabrobot",
    "sila2",
    "opcua",
    "python",
)
"""Drivers whose config says the actions; each has a twin, `sim_scpi`, that takes the same config."""
SHIPPED = {
    "sim_gantry": "labrun.drivers.simulated.gantry:SimGantry",
    "sim_libs": "labrun.drivers.simulated.libs:SimLibs",
    "sim_balance": "labrun.drivers.simulated.balance:SimBalance",
    "sim_pipette": "labrun.drivers.simulated.pipette:SimPipette",
    "sim_colour_camera": "labrun.drivers.simulated.colour_camera:SimColourCamera",
    "sim_pump": "labrun.drivers.simulated.pump:SimPump",
    "sim_ph_probe": "labrun.drivers.simulated.ph_probe:SimPhProbe",
    "sim_furnace": "labrun.drivers.simulated.furnace:SimFurnace",
    "sim_leak_sensor": "labrun.drivers.simulated.leak_sensor:SimLeakSensor",
    "sim_plate_reader": "labrun.drivers.simulated.plate_reader:SimPlateReader",
    "sim_microscope": "labrun.drivers.simulated.microscope:SimMicroscope",
    "sim_dispenser": "labrun.drivers.simulated.dispenser:SimDispenser",
    "sim_messenger": "labrun.drivers.simulated.messenger:SimMessenger",
    "sim_depth_camera": "labrun.drivers.simulated.depth_camera:SimDepthCamera",
    "stereo_camera": "labrun.drivers.cameras.stereo_camera:StereoCamera",
    "realsense": "labrun.drivers.cameras.realsense:RealSense",
    "oak": "labrun.drivers.cameras.oak:Oak",
    "reducer": "labrun.drivers.reducer:Reducer",
    "gp": "labrun.drivers.optimizer.gp:Gp",
    "optuna": "labrun.drivers.optimizer.by_optuna:Optuna",
    "gpcam": "labrun.drivers.optimizer.by_gpcam:Gpcam",
    "baybe": "labrun.drivers.optimizer.by_baybe:Baybe",
    "apprise": "labrun.drivers.messenger.messenger:Messenger",
    "balance": "labrun.drivers.balance.driver:Balance",
    "grbl": "labrun.drivers.grbl.gantry:Grbl",
    "marlin": "labrun.drivers.marlin.gantry:Marlin",
    "moonraker": "labrun.drivers.moonraker.gantry:Moonraker",
    "zaber": "labrun.drivers.zaber.gantry:Zaber",
    "openbuilds": "labrun.drivers.openbuilds.gantry:OpenBuilds",
    "aecp": "labrun.drivers.aecp.driver:Aecp",
    "sciaps_gui": "labrun.drivers.sciaps_gui.driver:SciapsGui",
    "window_program": "labrun.drivers.window_program.driver:WindowProgram",
    "ros_action": "labrun.drivers.ros_action.driver:RosAction",
    **{name: f"labrun.drivers.bridges.{name}:{name.capitalize()}" for name in BRIDGES},
    **{f"sim_{name}": f"labrun.drivers.simulated.said:Sim{name.capitalize()}" for name in BRIDGES},
}
"""Drivers that come with labrun; the entry-point group `labrun.drivers` adds others."""

GROUP = "labrun.drivers"


class DriverFault(ValueError):
    """A driver that cannot be used, with the reason."""


def driver_places() -> dict[str, str]:
    """Driver name -> `module:Class`, for the shipped ones and for every installed package."""
    from importlib.metadata import entry_points

    return {entry.name: entry.value for entry in entry_points(group=GROUP)} | SHIPPED


def find_driver(name: str, base: Path) -> type[Driver]:
    """The driver class that a lab calls `name`: a known name, or `./file.py:Class` beside `base`."""
    if ":" in name:
        path, _, class_name = name.rpartition(":")
        module = _module_from_file(name, base / path)
    else:
        place = SHIPPED.get(name) or driver_places().get(name)
        if place is None:
            raise DriverFault(
                f"there is no driver {name!r}; the drivers are {', '.join(sorted(driver_places()))}; "
                f"write your own file as ./my_driver.py:Class"
            )
        module_name, _, class_name = place.partition(":")
        module = _module(name, module_name)
    found = getattr(module, class_name, None)
    if not (isinstance(found, type) and issubclass(found, Driver)):
        raise DriverFault(
            f"driver {name!r}: {class_name} is not a class in {module.__name__} derived from "
            f"labrun.drivers.driver.Driver"
        )
    return found


def _module(name: str, module_name: str) -> ModuleType:
    try:
        return importlib.import_module(module_name)
    except ImportError as fault:
        why = not_installed(fault, OF_DRIVERS.get(name)) or str(fault)
        raise DriverFault(f"driver {name!r} cannot be loaded: {why}") from fault


def _module_from_file(name: str, path: Path) -> ModuleType:
    if not path.is_file():
        raise DriverFault(f"driver {name!r}: there is no file {path}")
    # The name holds the path's hash, so that two labs' my_driver.py do not shadow one another.
    module_name = (
        f"labrun_driver_{path.stem}_{sha256(str(path.resolve()).encode()).hexdigest()[:8]}"
    )
    spec = importlib.util.spec_from_file_location(module_name, path)
    if spec is None or spec.loader is None:
        raise DriverFault(f"driver {name!r}: {path} is not a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as fault:  # whatever a third-party file raises is an error in that file
        del sys.modules[module_name]
        raise DriverFault(f"driver {name!r}: {path}: {in_words(fault)}") from fault
    return module


def check_installed(driver: type[Driver], config: dict[str, Any]) -> None:
    """Raise DriverFault, with the line that adds it, if what a driver of labrun needs is not installed."""
    if (why := driver.lacks(config)) is not None:
        raise DriverFault(f"the driver {driver.__name__} cannot work: {why}")


def speaks(driver: type[Driver], contract: Contract) -> bool:
    """Whether a driver is one for this contract or one that it `also` keeps: its own, or an earlier one."""
    spoken = getattr(driver, "contract", None)
    known = shipped_contracts().get(spoken) if isinstance(spoken, str) else None
    kept = (contract.type, *contract.also)
    return spoken in kept or (known is not None and any(known.keeps(one) for one in kept))


def check_driver(driver: type[Driver], contract: Contract) -> None:
    """Raise DriverFault listing every way in which the driver breaks the contract."""
    faults = list(_faults(driver, contract))
    if faults:
        raise DriverFault(
            f"driver {driver.__name__} does not keep the contract {contract.type}: "
            + "; ".join(faults)
        )


def _faults(driver: type[Driver], contract: Contract) -> Iterator[str]:
    if driver.any_contract:
        return  # only its configuration may not fit, and the driver reports that
    if not speaks(driver, contract):
        spoken = getattr(driver, "contract", None)
        said = f"it is a driver for {spoken}" if spoken else "it does not say for which it is one"
        yield f'{said}: write `contract = "{contract.type}"` below its `class` line if it keeps that'
    for name in contract.safe_state:
        if name not in contract.actions:
            yield f"the safe state names {name}, which is not an action of the contract"
    for name, action in contract.actions.items():
        method = getattr(driver, name, None)
        if not inspect.iscoroutinefunction(method):
            yield f"it has no `async def {name}`"
        else:
            yield from _parameter_faults(name, method, action)


def _parameter_faults(name: str, method: Any, action: Action) -> Iterator[str]:
    wanted = list(action.param_schemas())
    accepted = dict(list(inspect.signature(method).parameters.items())[2:])  # after self and goal
    if not any(p.kind is p.VAR_KEYWORD for p in accepted.values()):
        for missing in [n for n in wanted if n not in accepted]:
            yield f"{name} does not accept the parameter {missing}"
    for parameter in accepted.values():
        needed = parameter.default is parameter.empty
        plain = parameter.kind in (parameter.KEYWORD_ONLY, parameter.POSITIONAL_OR_KEYWORD)
        if plain and needed and parameter.name not in action.required():
            yield f"{name} requires {parameter.name}, which the contract does not require"
