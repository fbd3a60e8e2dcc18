"""The lab that tortured runs use: the same devices, slow enough to be killed in mid-action."""

import json
from pathlib import Path
from typing import Any

from ..lab.lab import LoadedLab
from ..language.yaml_write import write_yaml

SPEED = 300
"""How many times faster than real the simulated clocks run: a shot of 8 s takes 27 ms."""


def write_lab(lab: LoadedLab, devices: list[str], path: Path, urls: dict[str, str]) -> None:
    """Write a lab file beside its contracts; a device with an address in `urls` is served elsewhere."""
    path.parent.mkdir(parents=True, exist_ok=True)
    told: dict[str, Any] = {"name": lab.lab.name, "simulated": True, "contracts": []}
    for contract in sorted({lab.lab.devices[name].contract for name in devices}):
        file = path.with_name(f"{contract.replace('@', '-')}.json")
        data = lab.contracts[contract].model_dump(mode="json", exclude_none=True)
        file.write_text(json.dumps(data), encoding="utf-8")
        told["contracts"].append(f"./{file.name}")
    told["devices"] = {name: _device(lab, name, urls.get(name)) for name in devices}
    with path.open("w", encoding="utf-8") as out:
        write_yaml(told, out)


def _device(lab: LoadedLab, name: str, url: str | None) -> dict[str, Any]:
    device = lab.lab.devices[name]
    limits = device.model_dump(mode="json", exclude_none=True, include={"limits"})
    where = {"driver": _driver(lab, name), "config": config(lab, name)}
    return {"contract": device.contract, **limits, **(where if url is None else {"url": url})}


def config(lab: LoadedLab, name: str) -> dict[str, Any]:
    """A device's configuration with the clock of torture, if it has a clock."""
    given = lab.lab.devices[name].config
    return {**given, "clock": SPEED} if "clock" in given else dict(given)


def _driver(lab: LoadedLab, name: str) -> str | None:
    driver = lab.lab.devices[name].driver
    if driver and ".py" in driver and lab.path is not None and not Path(driver).is_absolute():
        return str((lab.path.parent / driver).resolve())
    return driver
