"""The lab as runs get it from this server: every device that it serves at a port of its own.

An engine uses what listens at a device's port, so that manual control, runs and STOP ALL all reach
the same device server; where none listens, as in a shell later, the engine starts its own there.
"""

import json
import socket
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

from ...engine.lab import LoadedLab, load_lab
from ..durable import write_durable


def bench_lab(lab: LoadedLab, state: Path) -> LoadedLab:
    """Write the lab with ports into `state` and load it again; raises OSError."""
    ports = _ports(lab, state / "ports.json")
    data = lab.lab.model_dump(mode="json", exclude_none=True, exclude_defaults=True)
    data["contracts"] = _contracts(lab, state / "contracts")
    base = lab.path.parent.resolve() if lab.path is not None else Path.cwd()
    for name, port in ports.items():
        device = data["devices"][name]
        device["port"] = port
        driver = device["driver"]
        if ".py" in driver and not Path(driver).is_absolute():
            device["driver"] = str((base / driver).resolve())
    path = state / "lab.yaml"
    write_durable(path, _yaml(data), mode=0o600)
    loaded, problems = load_lab(path)
    if loaded is None:
        raise OSError(f"{path} cannot be read again: {problems[0].message if problems else ''}")
    return loaded


def _ports(lab: LoadedLab, path: Path) -> dict[str, int]:
    """Device -> port; the same ones as long as nobody else has taken them."""
    try:
        known: dict[str, int] = json.loads(path.read_bytes())
    except (OSError, ValueError):
        known = {}
    ports: dict[str, int] = {}
    for name, device in lab.lab.devices.items():
        if device.driver is not None:
            ports[name] = device.port or known.get(name) or _free_port({*ports.values()})
    write_durable(path, json.dumps(ports).encode())
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
        contract = lab.contracts[kind].model_dump(mode="json", exclude_none=True)
        write_durable(path, _yaml(contract))
        names.append(f"./{folder.name}/{path.name}")
    return names


def _yaml(data: Any) -> bytes:
    from io import BytesIO

    out = BytesIO()
    yaml = YAML(typ="safe", pure=True)
    yaml.sort_base_mapping_type_on_output = False  # pyright: ignore[reportAttributeAccessIssue]
    yaml.dump(data, out)
    return out.getvalue()
