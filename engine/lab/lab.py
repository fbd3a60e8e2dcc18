"""Read a lab: its devices, their contracts, the limits of the bench."""

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ...schemas.also import broken_promises
from ...schemas.contract import Contract, JsonSchema
from ...schemas.contracts import ContractFault, shipped_contracts
from ...schemas.lab import Lab, LabDevice, Limit
from ...schemas.patterns import (
    check_schema,
    ranges_of_nothing,
    schema_fault_words,
    unknown_keywords,
    validator,
)
from ...schemas.problem import Problem
from ...schemas.quantity import UnitError, magnitude_in, unit_fault
from ...system import NO_FILE, WINDOWS
from ...system.extras import OF_DRIVERS, missing
from ..language.file_text import file_text
from ..language.shape import read_model
from ..language.source import Source, parse_source, read_source
from ..language.suggest import did_you_mean, listed
from .addresses import one_address
from .config_contracts import broken, said_contracts

SHIPPED = Path(__file__).parents[2] / "protocols"
CONFIGLESS = {"reducer", "gp", "optuna", "gpcam", "baybe", "oak", "realsense", "moonraker"}
"""Drivers that ship and need no `config`, as twins do not: they are not read to see that it is missing."""
OF_DRIVER = "last_once"
"""The probe that a bridge adds by itself."""
CODES = {
    "E130": "a contract of a lab that cannot be used",
    "W130": "a driver that is not installed here",
    "W131": "two devices at one address",
    "W133": "a folder of a lab that is not there",
    "E132": "a config that does not fit its driver or its contract",
    "E131": "a limit of a lab for an unknown parameter, or in the wrong unit",
}


@dataclass(slots=True)
class LoadedLab:
    """A lab with the contracts that its devices may have: those that ship and its own.

    `served_as` is, for a run's copy, the name under which `labrun serve` serves the file it is of.
    """

    lab: Lab
    path: Path | None
    contracts: dict[str, Contract]
    source: Source
    served_as: str = ""

    @property
    def folders(self) -> tuple[Path, ...]:
        """Folders from which any protocol may take files, beside its own."""
        here = self.path.parent if self.path is not None else Path()
        return tuple(here / folder for folder in self.lab.folders)

    def lacking(self, devices: Iterable[str]) -> dict[str, str]:
        """Of these devices those whose drivers need what is not installed here -> what adds it.

        A driver in a person's own file is not loaded to find out.
        """
        found = {name: _lacks(self.lab.devices[name]) for name in devices}
        return {name: why for name, why in found.items() if why is not None}

    def keeping(self, contract: str) -> list[str]:
        """The devices that can play a role that needs this contract."""
        return [
            name
            for name, device in self.lab.devices.items()
            if (its := self.contracts.get(device.contract)) is not None and its.keeps(contract)
        ]


def _lacks(device: LabDevice) -> str | None:
    if device.driver is None or device.python is not None:
        return None  # what another Python has, it says itself
    if "actions" in device.config:  # what such a driver needs depends on its instrument
        from ...drivers.find import BRIDGES, find_driver

        if device.driver in BRIDGES:
            return find_driver(device.driver, Path()).lacks(device.config)
    extra = OF_DRIVERS.get(device.driver)
    return missing(extra) if extra is not None else None


def load_lab(path: Path | None) -> tuple[LoadedLab | None, list[Problem]]:
    """A lab from its file, or the simulated lab that ships, and the problems found in it."""
    if path is None:
        name = "labs/simulated.yaml"
        text = (SHIPPED / name).read_text(encoding="utf-8")
        source, problems = parse_source(text, Path(name), name)
    else:
        source, problems = read_source(path)
    if source is None:
        return None, problems
    if _is_protocol(source.data):
        hint = "give the lab, which says where the devices are; `labrun check` reads a protocol"
        return None, [source.problem((), "E113", "this is a protocol, not a lab", hint)]
    lab, more = read_model(Lab, source.data, source, (), "a lab")
    problems += more
    if lab is None:
        return None, problems
    contracts, more, unread = _contracts(lab, source, path)
    problems += more
    problems += said_contracts(lab, contracts, source)
    problems += _check_names(lab, source)
    problems += _check_devices(lab, contracts, source, path, unread)
    problems += one_address(lab, source)
    here = path.parent if path is not None else Path()
    for index, folder in enumerate(lab.folders):
        if not (here / folder).is_dir():
            hint = f"it is looked for as {(here / folder).absolute()}"
            problems.append(
                source.problem(("folders", index), "W133", f"there is no folder {folder}", hint)
            )
    return LoadedLab(lab, path, contracts, source), problems


def _is_protocol(data: Any) -> bool:
    """True for a protocol: it has steps, or says its version and names contracts only."""
    if not isinstance(data, dict) or "steps" in data:
        return isinstance(data, dict)
    devices = data.get("devices")
    named = devices.values() if isinstance(devices, dict) else ()
    return "labrun" in data and not any(isinstance(device, dict) for device in named)


def _contracts(
    lab: Lab, source: Source, path: Path | None
) -> tuple[dict[str, Contract], list[Problem], bool]:
    """Contract type -> contract, the problems of the lab's own, and whether one could not be read."""
    contracts = dict(shipped_contracts())
    problems: list[Problem] = []
    own: dict[int, Contract] = {}
    unread = False
    folder = path.parent if path is not None else Path()
    for index, name in enumerate(lab.contracts):
        text = file_text(folder / name)
        if not isinstance(text, str):
            message = f"{name}: {text.message}"
            problems.append(source.problem(("contracts", index), "E130", message, text.hint))
            unread = True
            continue
        its, told = parse_source(text, folder / name, str(folder / name))
        contract, more = _own_contract(its)
        problems += [*told, *more]
        if contract is not None and not any(one.severity == "error" for one in more):
            problems += _replaces(contract, source, index)
            contracts[contract.type] = own[index] = contract
        else:
            unread = True
    for index, contract in own.items():
        if told := list(_also_faults(contract, contracts)):
            message = f"{contract.type} does not keep {'; '.join(told)}"
            problems.append(source.problem(("contracts", index), "E130", message))
    return contracts, problems, unread


def _replaces(contract: Contract, source: Source, index: int) -> Iterator[Problem]:
    """A contract with the name of one that ships, and other words: a run's copies have the same."""
    name = contract.type
    if shipped_contracts().get(name, contract) != contract:
        message = f"this {name} takes the place of the one that ships with labrun"
        hint = f"protocols and drivers of {name} may want the other: give it a name of its own"
        yield source.problem(("contracts", index), "E130", message, hint, severity="warning")


def _own_contract(source: Source | None) -> tuple[Contract | None, list[Problem]]:
    """A lab's own contract, and what is wrong in its file."""
    if source is None:
        return None, []
    contract, problems = read_model(Contract, source.data, source, (), "a contract")
    if contract is None and _is_protocol(source.data):
        return None, [source.problem((), "E113", "this is a protocol, not a contract")]
    if contract is not None:
        try:
            check_schemas(contract)
        except ContractFault as fault:
            problems = [source.problem(fault.place, "E130", str(fault))]
    return contract, problems


def _also_faults(contract: Contract, contracts: dict[str, Contract]) -> Iterator[str]:
    """What a contract's `also` claims wrongly."""
    for earlier in contract.also:
        if earlier not in contracts:
            yield f"{earlier}, which is not known{did_you_mean(earlier, contracts)}"
        elif broken := list(broken_promises(contract, contracts[earlier])):
            yield f"{earlier}: {', '.join(broken)}"


def check_schemas(contract: Contract) -> None:
    """Raise ContractFault for an invalid schema, unit or interlock in a contract."""
    _check_schema("status", contract.status, ("status",))
    for action_name, action in contract.actions.items():
        try:
            check_interlock(f"{action_name}.interlock", action.interlock, contract.status)
        except ContractFault as fault:
            raise ContractFault(str(fault), ("actions", action_name, "interlock")) from fault
        for part, schema in (("params", action.params), ("returns", action.returns)):
            _check_schema(f"{action_name}.{part}", schema, ("actions", action_name, part))
        probe = contract.actions.get(action.probe or "")
        if probe is not None and probe.effect != "pure":
            message = f"{action_name}.probe: {action.probe} is {probe.effect}; a probe is `pure`"
            raise ContractFault(message, ("actions", action_name, "probe"))
        if action.probe not in (None, OF_DRIVER, *contract.actions):
            guess = did_you_mean(str(action.probe), contract.actions)
            message = f"{action_name}.probe: there is no action {action.probe}{guess}"
            raise ContractFault(message, ("actions", action_name, "probe"))
    for index, name in enumerate(contract.safe_state):
        if name not in contract.actions:
            guess = did_you_mean(name, contract.actions)
            raise ContractFault(
                f"safe_state: there is no action {name}{guess}", ("safe_state", index)
            )
        if needs := contract.actions[name].required():
            message = f"safe_state: {name} is called without parameters, and needs {listed(needs)}"
            raise ContractFault(message, ("safe_state", index))
    known = list(_units(contract.model_dump(include={"status", "actions"}), ()))
    for path, unit, said in known:
        about = ".".join(str(part) for part in path if part not in ("actions", "properties"))
        if words := unit_fault(unit, f"{about} {said}", [one for _, one, _ in known]):
            raise ContractFault(f"{about}: {words}", (*path, "unit"))


def _check_schema(where: str, schema: JsonSchema, place: tuple[str, ...]) -> None:
    from jsonschema import SchemaError

    try:
        check_schema(schema)
    except SchemaError as fault:
        message = f"{where} is not a valid JSON Schema: {schema_fault_words(fault)}"
        raise ContractFault(message, (*place, *fault.absolute_path)) from fault
    for path, known in unknown_keywords(schema):
        guess = did_you_mean(path[-1], known)
        message = f"{where}: unknown key {'.'.join(path)}{guess}"
        if len(path) == 1 and isinstance(schema[path[0]], dict) and not guess:
            message += "; each of them stands below `properties:`"
        raise ContractFault(message, (*place, *path))
    for path, said in ranges_of_nothing(schema):
        raise ContractFault(f"{where}: {said}", (*place, *path))
    for name, one in schema.get("properties", {}).items():
        if (
            isinstance(one, dict)
            and "default" in one
            and not validator(one).is_valid(one["default"])
        ):
            message = f"{where}.{name}: the default {one['default']!r} is not a value that it takes"
            raise ContractFault(message, (*place, "properties", name, "default"))


def check_interlock(where: str, interlock: dict[str, Any], status: JsonSchema) -> None:
    """Raise ContractFault for what the status cannot be: the action would never begin."""
    fields = status.get("properties", {})
    for field, wanted in interlock.items():
        if field not in fields:
            guess = did_you_mean(field, fields)
            raise ContractFault(
                f"{where}: the status has no {field}{guess}; it has {listed(fields)}"
            )
        for fault in validator(fields[field]).iter_errors(wanted):
            raise ContractFault(f"{where}.{field} never holds: {fault.message}")


def _units(
    schema: Any, path: tuple[str | int, ...]
) -> Iterator[tuple[tuple[str | int, ...], str, str]]:
    """Where a `unit` stands beside a `type` in a schema, the unit, and what is said of its value."""
    if isinstance(schema, dict):
        if "unit" in schema and "type" in schema:
            yield path, str(schema["unit"]), str(schema.get("description", ""))
        for key, inner in schema.items():
            yield from _units(inner, (*path, key))
    elif isinstance(schema, list):
        for index, inner in enumerate(schema):
            yield from _units(inner, (*path, index))


def _check_names(lab: Lab, source: Source) -> Iterator[Problem]:
    """Each device has a folder of its name: one that is none of another's on any system."""
    known: dict[str, str] = {}
    for name in lab.devices:
        place = ("devices", name)
        other = known.setdefault(name.lower(), name)
        if other != name:
            message = f"{other} and {name} would share a folder on Windows and macOS"
            yield source.problem(
                place, "E112", message, "they differ only in case; rename one", key=True
            )
        if WINDOWS and NO_FILE.search(name):
            message = f"on Windows no folder can be named {name}"
            yield source.problem(place, "E112", message, f"such as {name}_", key=True)


def _check_devices(
    lab: Lab, contracts: dict[str, Contract], source: Source, path: Path | None, unread: bool
) -> Iterator[Problem]:
    ports: dict[int, str] = {}
    for name, device in lab.devices.items():
        yield from _check_driver(name, device, source) if path is not None else ()
        other = ports.setdefault(device.port, name) if device.port and device.driver else name
        if other != name:
            message = f"port {device.port} is already that of {other}"
            hint = "without `port`, one that is free is taken"
            yield source.problem(("devices", name, "port"), "E112", message, hint)
        contract = contracts.get(device.contract)
        if contract is None and broken(name, device, source):
            continue  # its config would say it, once it can be read
        if contract is None:
            guess = did_you_mean(device.contract, contracts)
            if unread and not guess:
                continue  # it may be in the file that has problems of its own
            message = f"there is no contract {device.contract}{guess}"
            hint = f"known: {listed(contracts)}; `contracts:` lists a lab's own"
            yield source.problem(("devices", name, "contract"), "E130", message, hint)
        else:
            yield from _check_limits(name, device, contract, source)
            yield from _check_config(name, device, contract, source) if path is not None else ()


def _check_driver(name: str, device: LabDevice, source: Source) -> Iterator[Problem]:
    """A driver of an unknown name; another interpreter, or a file of the lab's own, may have any."""
    driver = device.driver
    if driver is None or device.python is not None:
        return
    file, _, class_name = driver.rpartition(":")
    if class_name and file.endswith(".py") and not (source.path.parent / file).is_file():
        message = f"there is no file {file} beside the lab"
        yield source.problem(("devices", name, "driver"), "W130", message)
    if class_name and file:
        return
    from ...drivers import find  # only here: the lab that ships needs no driver to be read

    known = find.SHIPPED if driver in find.SHIPPED else find.driver_places()
    if driver not in known:
        message = f"no driver {driver} is installed here{did_you_mean(driver, known)}"
        hint = f"known: {listed(sorted(known))}; one of your own is written ./my_driver.py:Class"
        yield source.problem(("devices", name, "driver"), "W130", message, hint)


def _check_config(
    name: str, device: LabDevice, contract: Contract, source: Source
) -> Iterator[Problem]:
    """What its driver does not take: one that ships says so when it is made, before all else."""
    if device.driver is None or device.python is not None:
        return
    if not device.config and (device.driver.startswith("sim_") or device.driver in CONFIGLESS):
        return  # the lab that ships needs no driver to be read
    from ...drivers import find
    from ...drivers.driver import Misfit, Place, UnknownKey

    if device.driver not in find.SHIPPED:
        return
    place = (
        ("devices", name, "config") if "config" in device.model_fields_set else ("devices", name)
    )
    with TemporaryDirectory() as kept:  # for what some keep from their first moment
        here = Path(kept)

        def fault_of(config: dict[str, Any]) -> Exception | None:
            try:
                driver = find.find_driver(str(device.driver), here)
                if "actions" not in config or not hasattr(driver, "config_model"):  # read above
                    driver(Place(name, config, {}, here, here, contract))
            except (OSError, ImportError, find.DriverFault):
                return None  # what is missing here is told where the device is served
            except Exception as fault:  # what a driver makes of a wrong value is anything
                return fault
            return None

        fault = fault_of(device.config)
        if isinstance(fault, Misfit):
            is_key = isinstance(fault, UnknownKey)
            yield source.problem((*place, *fault.path), "E132", str(fault), key=is_key)
            return
        if fault is not None:  # by the one without which there is none
            for key, value in device.config.items():
                if fault_of({k: v for k, v in device.config.items() if k != key}) is None:
                    words = f"{key} is {value!r}, which {device.driver} does not take"
                    message = str(fault) if key in str(fault) else words
                    yield source.problem((*place, key), "E132", message)
                    return
            if isinstance(fault, ValueError):  # what it says that it needs is missing
                yield source.problem(place, "E132", str(fault), key=not device.config)
            return
        with suppress(OSError, ImportError, find.DriverFault):
            driver = find.find_driver(str(device.driver), here)
            if not (driver.any_contract or find.speaks(driver, contract)):
                message = (
                    f"{device.driver} is a driver for {driver.contract}, not for {contract.type}"
                )
                yield source.problem(("devices", name, "contract"), "E132", message)


def _check_limits(
    name: str, device: LabDevice, contract: Contract, source: Source
) -> Iterator[Problem]:
    schemas = {
        param: schema
        for action in contract.actions.values()
        for param, schema in action.param_schemas().items()
    }
    for param, limit in device.limits.items():
        place = ("devices", name, "limits", param)
        if param not in schemas:
            message = f"no action of {device.contract} has a parameter {param}"
            hint = f"it has {listed(schemas)}"
            yield source.problem(
                place, "E131", message + did_you_mean(param, schemas), hint, key=True
            )
            continue
        unit = schemas[param].get("unit", "")
        yield from _check_order(limit, schemas[param], source, place)
        for bound in ("minimum", "maximum"):
            try:
                magnitude_in(getattr(limit, bound) or 0, unit)
            except UnitError as fault:
                yield source.problem((*place, bound), "E131", f"{param}: {fault}")
            else:
                yield from _check_wider(
                    device, param, bound, schemas[param], source, (*place, bound)
                )


def _check_order(
    limit: Limit, schema: JsonSchema, source: Source, place: tuple[str, ...]
) -> Iterator[Problem]:
    """A range in which nothing lies, of its own or together with the contract's."""
    unit = schema.get("unit", "")
    low, high = limit.minimum, limit.maximum
    if low is None and high is None:
        return
    bounds = [
        schema.get("minimum") if low is None else low,
        schema.get("maximum") if high is None else high,
    ]
    try:
        least, most = (None if one is None else magnitude_in(one, unit) for one in bounds)
    except UnitError:
        return  # told of the bound
    if least is None or most is None or least <= most:
        return
    if low is not None and high is not None:
        message = f"{place[-1]}: the minimum {low} is above the maximum {high}"
        yield source.problem((*place, "minimum"), "E131", message, "exchange the two")
        return
    own, bound = ("minimum", "maximum") if low is None else ("maximum", "minimum")
    message = f"{place[-1]}: a {bound} of {getattr(limit, bound)} leaves nothing: the contract's own {own} is"
    message += f" {schema[own]:g} {unit}".rstrip()
    yield source.problem((*place, bound), "E131", message)


def _check_wider(
    device: LabDevice, param: str, bound: str, schema: Any, source: Source, place: tuple[str, ...]
) -> Iterator[Problem]:
    """A limit beyond the contract's own range changes nothing, which its author cannot know."""
    written, own = getattr(device.limits[param], bound), schema.get(bound)
    if written is None or own is None:
        return
    unit = schema.get("unit", "")
    value = magnitude_in(written, unit)
    if value < own if bound == "minimum" else value > own:
        message = (
            f"{param}: {device.contract} itself goes to {own:g} {unit}".rstrip()
            + f", so a {bound} of {written} changes nothing"
        )
        hint = "a limit can narrow a contract, not widen it"
        if device.contract == "gantry@1":
            hint += "; with `contract: gantry@2` the range is the lab's or the machine's"
        yield source.problem(place, "E131", message, hint, severity="warning")
