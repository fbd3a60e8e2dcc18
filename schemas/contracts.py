"""Find contracts by type: those that ship with labrun and those a lab brings along."""

from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from .contract import Contract


class ContractFault(ValueError):
    """A contract file that cannot be read, with the reason in words."""


def parse_contract(text: str, name: str) -> Contract:
    """A contract from its YAML text; `name` is what a fault calls the file."""
    try:
        data: Any = YAML(typ="safe", pure=True).load(text)
        return Contract.model_validate(data)
    except YAMLError as fault:
        raise ContractFault(f"{name} is not YAML: {str(fault).splitlines()[0]}") from fault
    except ValidationError as fault:
        first = fault.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        raise ContractFault(f"{name}: {place}: {first['msg']}") from fault


def read_contract(path: Path) -> Contract:
    """A contract from a file of a lab's own."""
    try:
        return parse_contract(path.read_text(encoding="utf-8"), str(path))
    except (OSError, UnicodeDecodeError) as fault:
        raise ContractFault(f"contract {path} cannot be read: {fault}") from fault


@cache
def shipped_contracts() -> dict[str, Contract]:
    """Contract type -> contract, for those that ship: `gantry@1`, `libs_analyzer@1`, ..."""
    folder = files("labrun.schemas.devices")
    found = [
        parse_contract(entry.read_text(encoding="utf-8"), entry.name)
        for entry in sorted(folder.iterdir(), key=lambda entry: entry.name)
        if entry.name.endswith(".yaml")
    ]
    return {contract.type: contract for contract in found}
