"""The lab as runs get it from here: every device that is served by this machine at a port of its own.

An engine uses what listens at a device's port, so that what is done by hand, goals of ROS, runs and
STOP ALL reach the same server; where none listens any more, as when a run is resumed in a shell
later, the engine starts its own there.
"""

import json
import socket
from pathlib import Path
from typing import Any

from ..engine.lab import LoadedLab, load_lab
from .durable import write_durable

NAME = "lab.yaml"


def lab_here(lab: LoadedLab, state: Path) -> LoadedLab:
    """Write the lab with ports into `state` and load it again; raises OSError."""
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
    write_durable(state / NAME, _json(data), mode=0o600)  # it may hold tokens
    loaded, problems = load_lab(state / NAME)
    if loaded is None:
        raise OSError(
            f"{state / NAME} cannot be read again: {problems[0].message if problems else ''}"
        )
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
            ports[name] = device.port or known.get(name) or _free_port({*ports.values()})
    write_durable(path, _json(ports))
    return ports


def _free_port(taken: set[int]) -> int:
    while True:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        if port not in taken:
            return port


def _contracts(lab: LoadedLab, folder: Path) -> list[str]:
    names = []
    for kind in sorted({device.contract for device in lab.lab.devices.values()}):
        path = folder / f"{kind.replace('@', '-')}.yaml"
        contract: dict[str, Any] = lab.contracts[kind].model_dump(mode="json", exclude_none=True)
        write_durable(path, _json(contract))
        names.append(f"./{folder.name}/{path.name}")
    return names


def _json(data: dict[str, Any]) -> bytes:
    return json.dumps(data, indent=1, ensure_ascii=False).encode()
