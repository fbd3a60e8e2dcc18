"""A run's inputs: its copies of protocol, lab and parameters, read for a report."""

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...engine.run.folder import ASKED, CONTRACTS, LAB, FolderFault, protocol_file


@dataclass(slots=True)
class Inputs:
    """The run's own copies as plain data; empty where one can no longer be read."""

    protocol: dict[str, Any] = field(default_factory=dict)
    protocol_name: str = ""
    protocol_text: str = ""
    lab: dict[str, Any] = field(default_factory=dict)
    asked: dict[str, Any] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)

    @property
    def simulated(self) -> bool:
        """True if no real device was used."""
        return bool(self.lab.get("simulated"))

    def param(self, name: str) -> dict[str, Any]:
        """The protocol's declaration of one of its parameters."""
        return _mapping(_mapping(self.protocol.get("params")).get(name))

    def given(self, name: str) -> bool:
        """True for a parameter set by the user; the others have the protocol's default."""
        return name in _mapping(self.asked.get("params"))

    def device(self, name: str) -> dict[str, Any]:
        """The lab's entry for one of its devices."""
        return _mapping(_mapping(self.lab.get("devices")).get(name))

    def contract_of(self, device: str) -> str:
        """`gantry@1`."""
        return str(self.device(device).get("contract", ""))

    def reached_by(self, device: str) -> str:
        """The driver that served a device, or the address of its server."""
        told = self.device(device)
        return str(told.get("url") or told.get("driver") or "")


def read_inputs(folder: Path) -> Inputs:
    """Read a run's inputs; a missing or damaged copy becomes a sentence in `faults`."""
    inputs = Inputs()
    try:
        path = protocol_file(folder)
        inputs.protocol_name = path.name
        inputs.protocol_text = path.read_text(encoding="utf-8", errors="replace")
        inputs.protocol = _yaml(inputs.protocol_text)
    except (FolderFault, OSError, ValueError) as fault:
        inputs.faults.append(f"the run's copy of the protocol cannot be read: {fault}")
    try:
        inputs.lab = _yaml((folder / LAB).read_text(encoding="utf-8"))
    except (OSError, ValueError) as fault:
        inputs.faults.append(f"the run's copy of the lab cannot be read: {fault}")
    try:
        inputs.asked = _mapping(json.loads((folder / ASKED).read_text(encoding="utf-8")))
    except (OSError, ValueError) as fault:
        inputs.faults.append(f"{ASKED} cannot be read: {fault}")
    return inputs


def contract_file(contract: str) -> str:
    """Where the run keeps its copy of a contract: `contracts/gantry-1.yaml`."""
    return f"{CONTRACTS}/{contract.replace('@', '-')}.yaml"


def _yaml(text: str) -> dict[str, Any]:
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    try:
        return _mapping(YAML(typ="safe", pure=True).load(text))
    except YAMLError as fault:
        raise ValueError(str(fault).splitlines()[0]) from fault


def _mapping(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}
