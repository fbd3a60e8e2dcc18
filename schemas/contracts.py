"""Find contracts by type: those that ship with labrun and a lab's own."""

import json
from functools import cache
from hashlib import sha256
from importlib.resources import files
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from .contract import Contract
from .model import first_fault

FOLDER = "labrun.schemas.devices"
READ = "contracts.json"
"""The same contracts as JSON, each with the hash of its YAML: loads a hundred times faster."""


class ContractFault(ValueError):
    """A contract file that cannot be read, with the reason."""


def parse_contract(text: str, name: str) -> Contract:
    """A contract from its YAML text; `name` is the file's name in error messages."""
    from ruamel.yaml.error import YAMLError

    try:
        return Contract.model_validate(_data(text))
    except YAMLError as fault:
        raise ContractFault(f"{name} is not YAML: {str(fault).splitlines()[0]}") from fault
    except ValidationError as fault:
        raise ContractFault(f"{name}: {first_fault(fault)}") from fault


def _data(text: str) -> Any:
    from ruamel.yaml import YAML

    return YAML(typ="safe", pure=True).load(text)


def read_contract(path: Path) -> Contract:
    """A contract from a lab's own file."""
    try:
        return parse_contract(path.read_text(encoding="utf-8"), str(path))
    except (OSError, UnicodeDecodeError) as fault:
        raise ContractFault(f"contract {path} cannot be read: {fault}") from fault


@cache
def shipped_contracts() -> dict[str, Contract]:
    """Contract type -> contract, for those that ship with labrun: `gantry@1`, `libs_analyzer@1`, ..."""
    read = json.loads((files(FOLDER) / READ).read_text(encoding="utf-8"))
    found = []
    for name, text in _texts().items():
        known = read.get(name, {})
        is_it = known.get("sha256") == _hash(text)
        found.append(
            Contract.model_validate(known["contract"]) if is_it else parse_contract(text, name)
        )
    return {contract.type: contract for contract in found}


def contracts_as_json() -> str:
    """What READ holds."""
    read = {n: {"sha256": _hash(t), "contract": _data(t)} for n, t in _texts().items()}
    return json.dumps(read, indent=1, ensure_ascii=False) + "\n"


def _texts() -> dict[str, str]:
    entries = sorted(files(FOLDER).iterdir(), key=lambda entry: entry.name)
    return {e.name: e.read_text(encoding="utf-8") for e in entries if e.name.endswith(".yaml")}


def _hash(text: str) -> str:
    return sha256(text.encode()).hexdigest()
