"""Where a lab's devices are served now, whoever has started their servers."""

import json
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from ...drivers.server.server_file import SETTINGS
from ..lab.lab import LoadedLab
from ..run.folder import all_runs, is_live
from .connect import base_of, servers_folder
from .served_lab import live_servers, named_at, serving_folders

CALLS = "labrun-call-*"
"""The temporary folders of `labrun call`, whose servers end with it."""


PAGE = Path(".labrun/web/bench/servers")
"""Where `labrun web` keeps those of its protocols' folder."""


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
        if (url := named_at(device)) is not None:
            found[name, url] = Serving(name, url, device.token)
    for url, served, settings in _local(lab, runs):
        for name in sorted(served & set(devices)):
            if settings is not None and not _is_ours(lab, name, settings):
                continue
            found.setdefault((name, url), Serving(name, url, lab.lab.devices[name].token))
    return sorted(found.values(), key=lambda serving: devices.index(serving.device))


def _local(lab: LoadedLab, runs: Path) -> Iterator[tuple[str, set[str], Path | None]]:
    """Address and devices of each server; its settings, where it may be another lab's."""
    folders = [*serving_folders(lab), runs.resolve().parent / PAGE]
    folders += [servers_folder(folder) for folder in all_runs(runs) if is_live(folder)]
    calls = [servers_folder(path) for path in Path(tempfile.gettempdir()).glob(CALLS)]
    for folder in (*folders, *calls):
        for path, words in live_servers(folder):
            settings = path.with_name(SETTINGS) if folder in calls else None
            yield str(words["url"]), set(words["devices"]), settings


def _is_ours(lab: LoadedLab, name: str, settings: Path) -> bool:
    """Whether a device of this name may be this lab's: from its folder, or the same instrument."""
    device = lab.lab.devices[name]
    try:
        told = json.loads(settings.read_bytes())
        same = told["devices"][name]["driver"], told["devices"][name]["config"]
        if told["base"] == base_of(lab):
            return True
        return not lab.lab.simulated and same == (device.driver, device.config)
    except (OSError, ValueError, KeyError, TypeError):
        return True  # one stop too many is better than one too few
