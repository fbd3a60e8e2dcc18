"""Find contracts by type: those that ship with labrun and a lab's own."""

import json
from functools import cache
from pathlib import Path
from typing import Any
from zlib import crc32

from pydantic import ValidationError

from .contract import Contract
from .model import first_fault

FOLDER = Path(__file__).parent / "devices"
READ = "contracts.json"
"""The same contracts as JSON, each with the checksum of its YAML: loads a hundred times faster."""


class ContractFault(ValueError):
    """A contract file that cannot be read, with the reason; `place`: where in it, if known."""

    def __init__(self, message: str, place: tuple[str | int, ...] = ()) -> None:
        super().__init__(message)
        self.place = place


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
        why = getattr(fault, "strerror", None) or "it is not UTF-8 text"
        raise ContractFault(f"contract {path} cannot be read: {why}") from fault


@cache
def shipped_contracts() -> dict[str, Contract]:
    """Contract type -> contract, for those that ship with labrun: `gantry@1`, `libs_analyzer@1`, ..."""
    read = json.loads((FOLDER / READ).read_text(encoding="utf-8"))
    found = []
    for name, text in _texts().items():
        known = read.get(name, {})
        is_it = known.get("crc32") == _checksum(text)
        found.append(
            Contract.model_validate(known["contract"]) if is_it else parse_contract(text, name)
        )
    return {contract.type: contract for contract in found}


def contracts_as_json() -> str:
    """What READ holds."""
    read = {n: {"crc32": _checksum(t), "contract": _data(t)} for n, t in _texts().items()}
    return json.dumps(read, indent=1, ensure_ascii=False) + "\n"


def _texts() -> dict[str, str]:
    return {path.name: path.read_text(encoding="utf-8") for path in sorted(FOLDER.glob("*.yaml"))}


def _checksum(text: str) -> int:
    return crc32(text.encode())
