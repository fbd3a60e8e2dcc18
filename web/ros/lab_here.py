"""The lab as runs get it from here: every device that is served by this machine at a port of its own.

An engine uses what listens at a device's port, so that goals of ROS and runs reach the same server;
where none listens any more, as when a run is resumed later, the engine starts its own there.
"""

import json
from pathlib import Path
from typing import Any

from ...engine.lab import LoadedLab, load_lab
from .listens import free_port

NAME = "lab.yaml"


def lab_here(lab: LoadedLab, state: Path) -> LoadedLab:
    """Write the lab with ports into `state` and load it again; raises OSError."""
    state.mkdir(parents=True, exist_ok=True)
    ports = _ports(lab, state / "ports.json")
    data = lab.lab.model_dump(mode="json", exclude_none=True, exclude_defaults=True)
    data.pop("ros", None)  # its paths are relative to where it was
    data["contracts"] = _contracts(lab, state / "contracts")
    base = lab.path.parent.resolve() if lab.path is not None else Path.cwd()
    for name, port in ports.items():
        device = data["devices"][name]
        device["port"] = port
        if ".py" in device["driver"]:
            path, _, class_name = device["driver"].rpartition(":")
            device["driver"] = f"{(base / path).resolve()}:{class_name}"
    # JSON is YAML, and needs no second opinion on what a string is.
    (state / NAME).write_text(json.dumps(data, indent=1), encoding="utf-8")
    (state / NAME).chmod(0o600)  # it may hold tokens
    loaded, problems = load_lab(state / NAME)
    if loaded is None:
        raise OSError(f"{state / NAME} cannot be read again: {problems[0].message}")
    return loaded


def _ports(lab: LoadedLab, path: Path) -> dict[str, int]:
    """Device -> port; the same ones every time, so that old runs find their devices again."""
    try:
        known: dict[str, int] = json.loads(path.read_bytes())
    except (OSError, ValueError):
        known = {}
    ports: dict[str, int] = {}
    for name, device in lab.lab.devices.items():
        if device.driver is not None:
            ports[name] = device.port or known.get(name) or free_port({*ports.values()})
    path.write_text(json.dumps(ports), encoding="utf-8")
    return ports


def _contracts(lab: LoadedLab, folder: Path) -> list[str]:
    folder.mkdir(exist_ok=True)
    names = []
    for kind in sorted({device.contract for device in lab.lab.devices.values()}):
        path = folder / f"{kind.replace('@', '-')}.yaml"
        contract: dict[str, Any] = lab.contracts[kind].model_dump(mode="json", exclude_none=True)
        path.write_text(json.dumps(contract, indent=1), encoding="utf-8")
        names.append(f"./{folder.name}/{path.name}")
    return names
