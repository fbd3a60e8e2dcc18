"""Where a lab's devices are served now, whoever has started their servers."""

import json
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path

from ...drivers.server.server_file import FILE
from ...system.process import alive
from ..lab.lab import LoadedLab
from ..run.folder import all_runs, is_live
from .connect import listens, servers_folder

CALLS = "labrun-call-*"
"""The temporary folders of `labrun call`, whose servers end with it."""


PAGE = Path(".labrun/web/bench/servers")
"""Where `labrun web` keeps those of its protocols' folder."""


def serve_home(lab: LoadedLab) -> Path:
    """Where `labrun serve` keeps a lab's, wherever it is given: a device's ledger must be found again."""
    from platformdirs import user_state_path

    name = "simulated"
    if lab.path is not None:
        path = lab.path.resolve()
        name = f"{path.stem}-{blake2b(str(path).encode(), digest_size=4).hexdigest()}"
    return user_state_path("labrun", appauthor=False) / "servers" / name


@dataclass(frozen=True, slots=True)
class Serving:
    """A server that has a device."""

    device: str
    url: str
    token: str | None = None


def servers_of(lab: LoadedLab, devices: list[str], runs: Path) -> list[Serving]:
    """Every server of these devices, whoever has started it.

    Those that the lab names, of `labrun serve` and `labrun web`, of live runs, and of calls by
    hand. A device has several only if they are on different hardware, or simulated.
    """
    found: dict[tuple[str, str], Serving] = {}
    for name in devices:
        device = lab.lab.devices[name]
        url = device.url
        if url is None and device.port is not None and listens(device.port):
            url = f"http://127.0.0.1:{device.port}"
        if url is not None:
            found[name, url] = Serving(name, url, device.token)
    for url, served in _local(lab, runs):
        for name in served & set(devices):
            found.setdefault((name, url), Serving(name, url, lab.lab.devices[name].token))
    return sorted(found.values(), key=lambda serving: devices.index(serving.device))


def _local(lab: LoadedLab, runs: Path) -> Iterator[tuple[str, set[str]]]:
    folders = [serve_home(lab), runs.resolve().parent / PAGE]
    folders += [servers_folder(folder) for folder in all_runs(runs) if is_live(folder)]
    folders += list(Path(tempfile.gettempdir()).glob(CALLS))
    for folder in folders:
        for path in folder.rglob(FILE):
            try:
                words = json.loads(path.read_bytes())
                if alive(words["pid"]):
                    yield str(words["url"]), set(words["devices"])
            except (OSError, ValueError, KeyError, TypeError):
                continue  # it is being written, or its server has just ended
