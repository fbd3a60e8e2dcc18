"""The lab that runs get from here: every device served by this machine has a separate port.

An engine uses the server listening at a device's port, so that manual actions, ROS goals, runs and
STOP ALL reach the same server; if none is listening, as when a run is resumed in a shell later,
the engine starts its own there.
"""

import json
import socket
from pathlib import Path
from typing import Any

from ...engine.dispatch.connect import python_of
from ...engine.dispatch.served_lab import served_at
from ...engine.lab.lab import LoadedLab, load_lab
from ...system.files import write_whole

NAME = "lab.yaml"


def lab_here(lab: LoadedLab, state: Path) -> LoadedLab:
    """Write the lab with ports into `state` and load it again; raises OSError."""
    ports = _ports(lab, state / "ports.json")
    data = lab.lab.model_dump(mode="json", exclude_none=True, exclude_defaults=True)
    data.pop("ros", None)  # its paths are relative to the original file
    data["contracts"] = _contracts(lab, state / "contracts")
    base = lab.path.parent.resolve() if lab.path is not None else Path.cwd()
    for name, port in ports.items():
        device = data["devices"][name]
        device["port"] = port
        if "python" in device:
            device["python"] = python_of(lab.lab.devices[name], lab)
        if ".py" in device["driver"]:
            path, _, class_name = device["driver"].rpartition(":")
            device["driver"] = f"{(base / path).resolve()}:{class_name}"
    # JSON is YAML, without its ambiguities about strings.
    write_whole(state / NAME, _json(data), mode=0o600)  # it may hold tokens
    loaded, problems = load_lab(state / NAME)
    if loaded is None:
        raise OSError(
            f"{state / NAME} cannot be read back: {problems[0].message if problems else ''}"
        )
    return loaded


def _ports(lab: LoadedLab, path: Path) -> dict[str, int]:
    """Device -> port; the same as long as `labrun serve` does not have it at another.

    So old runs find their devices again.
    """
    try:
        known: dict[str, int] = json.loads(path.read_bytes())
    except (OSError, ValueError):
        known = {}
    ports: dict[str, int] = {}
    for name, device in lab.lab.devices.items():
        if device.driver is not None:
            served = (served_at(lab, name) or "").rpartition(":")[2]
            port = device.port or int(served or 0) or known.get(name)
            ports[name] = port or _free_port({*ports.values()})
    write_whole(path, _json(ports))
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
        write_whole(path, _json(contract))
        names.append(f"./{folder.name}/{path.name}")
    return names


def _json(data: dict[str, Any]) -> bytes:
    return json.dumps(data, indent=1, ensure_ascii=False).encode()
