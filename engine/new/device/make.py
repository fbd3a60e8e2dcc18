"""Make the files of `labrun new device`, and reject unsuitable names and contracts."""

import keyword
import re
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from ....schemas.contract import Contract
from ....schemas.contracts import ContractFault, parse_contract, read_contract, shipped_contracts
from ....system import NO_FILE
from ...lab.lab import check_schemas
from ...language.suggest import did_you_mean, listed
from ..protocol import CannotMake
from . import render
from .entry import test_text

NAME = re.compile(r"[a-z][a-z0-9_]{0,40}")
LAB = "lab.yaml"


@dataclass(frozen=True, slots=True)
class NewDevice:
    """Files to be written, and the lines to add to an existing lab."""

    files: dict[str, str]
    device: str
    contract_file: str | None


def device_name(name: str, *, as_module: bool = False) -> str:
    """The name, if labs can have it, and Python's files; otherwise raises CannotMake."""
    if NAME.fullmatch(name) is None or keyword.iskeyword(name):
        if keyword.iskeyword(name):
            raise CannotMake(f"{name!r} is a Python keyword; choose another name")
        better = re.sub(r"\W+", "_", name.lower()).strip("_")
        guess = f"; {better!r} would do" if NAME.fullmatch(better) else ""
        raise CannotMake(
            f"{name!r} is not a valid device name: lower-case letters, digits and _, a letter first{guess}"
        )
    if NO_FILE.search(name):
        raise CannotMake(f"{name!r} cannot be a file or folder on Windows; choose another name")
    found = find_spec(name) if as_module and not Path(f"{name}.py").exists() else None
    if found is not None and found.origin is not None:
        raise CannotMake(
            f"there is already a Python module {name!r}, which {name}.py would hide; choose another name"
        )
    return name


def new_device(name: str, wanted: str | None, *, with_lab: bool) -> NewDevice:
    """The files of a device; `wanted` is a contract that ships, a contract file, or None for a new one.

    Raises CannotMake for an unsuitable name or contract.
    """
    name, own, files = device_name(name, as_module=True), f"{name}.yaml", dict[str, str]()
    if wanted is None:
        if f"{name}@1" in shipped_contracts():
            raise CannotMake(
                f"there is already a contract {name}@1: use it with --contract {name}@1, or choose "
                "another name"
            )
        files[own], count = render.contract_text(name), {"fire": "shots"}
        contract, contract_file = parse_contract(files[own], own), own
    else:
        count = {}
        contract, contract_file = _contract(wanted)
    files[f"{name}.py"] = render.driver_text(name, contract, count)
    files[f"test_{name}.py"] = test_text(name, LAB)
    device = render.device_text(name, contract)
    if with_lab:
        files[LAB] = render.lab_text(name, contract, contract_file, device)
    return NewDevice(files, device, contract_file)


def speaking_device(name: str, language: str, wanted: str | None) -> tuple[str, str | None]:
    """The lines of a lab for a device that is said there, and the file of its contract; raises CannotMake."""
    name = device_name(name)
    if wanted is None:
        return render.speaking_text(name, language), None
    contract, contract_file = _contract(wanted)
    if sent := [n for n, a in contract.actions.items() if a.path_params()[0]]:
        raise CannotMake(
            f"{sent[0]} of {contract.type} sends a file, which no line says; leave out --speaks"
        )
    return render.speaking_contract_text(name, language, contract), contract_file


def _contract(wanted: str) -> tuple[Contract, str | None]:
    shipped = shipped_contracts()
    if wanted in shipped:
        return shipped[wanted], None
    if not wanted.endswith((".yaml", ".yml")):
        raise CannotMake(
            f"there is no contract {wanted}{did_you_mean(wanted, shipped)}; there is {listed(shipped)}, "
            "or give your own as a file, --contract ./furnace.yaml"
        )
    try:
        contract = read_contract(Path(wanted))
        check_schemas(contract)
    except ContractFault as fault:
        said = "" if wanted in str(fault) else f"{wanted}: "
        raise CannotMake(f"{said}{fault}") from fault
    return contract, Path(wanted).as_posix().removeprefix("./")
