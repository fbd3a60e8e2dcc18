"""Where a lab's device is served now: where the lab names a server, or by `labrun serve` or `labrun web`."""

import contextlib
import json
import os
import socket
from collections.abc import Iterator
from hashlib import blake2b
from pathlib import Path
from typing import Any

from ...drivers.server.server_file import FILE, SETTINGS
from ...schemas.lab import LabDevice
from ...system.files import remove, write_whole
from ...system.process import alive
from ..lab.lab import LoadedLab

CHOSEN = "chosen_folders.txt"
"""Beside a lab's servers: the other folders in which it was served."""


def serve_home(lab: LoadedLab) -> Path:
    """Where `labrun serve` keeps a lab's, wherever it is given: a device's ledger must be found again."""
    name = lab.served_as or "simulated"
    if lab.path is not None and not lab.served_as:
        path = lab.path.resolve()
        name = f"{path.stem}-{blake2b(str(path).encode(), digest_size=4).hexdigest()}"
    return _homes() / name


def _homes() -> Path:
    from platformdirs import user_state_path

    return user_state_path("labrun", appauthor=False) / "servers"


def serving_folders(lab: LoadedLab) -> list[Path]:
    """Where its servers may be: its home, and the folders that a person chose."""
    return _folders(serve_home(lab))


def _folders(home: Path) -> list[Path]:
    chosen = ""
    with contextlib.suppress(OSError):
        chosen = (home / CHOSEN).read_text(encoding="utf-8")
    return [home, *map(Path, chosen.splitlines())]


def serves_in(lab: LoadedLab, folder: Path) -> None:
    """Note a folder that a person chose, so that this user's commands find the servers in it."""
    known = serving_folders(lab)
    if folder not in known:
        known[0].mkdir(parents=True, exist_ok=True)
        text = "".join(f"{path}\n" for path in [*known[1:], folder])
        write_whole(known[0] / CHOSEN, text.encode(), sync=False)


@contextlib.contextmanager
def starting(lab: LoadedLab, devices: list[str]) -> Iterator[None]:
    """Tell this user's other commands that these devices are about to be served, while the block lasts."""
    path = serve_home(lab) / f"starting-{os.getpid()}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, json.dumps({"pid": os.getpid(), "devices": devices}).encode(), sync=False)
    try:
        yield
    finally:
        remove(path)


def started_by(lab: LoadedLab, device: str) -> int | None:
    """The process of the `labrun serve` that is about to serve a device; None if none is."""
    if lab.path is None:
        return None  # as in `served_at`
    for path in serve_home(lab).glob("starting-*.json"):
        with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
            words = json.loads(path.read_bytes())
            if device in words["devices"] and alive(words["pid"]):
                return int(words["pid"])
    return None


def named_at(device: LabDevice) -> str | None:
    """The address that the lab names, if it is a `url`, or a `port` at which a server listens now."""
    if device.url is not None or device.port is None or not listens(device.port):
        return device.url
    return f"http://127.0.0.1:{device.port}"


def listens(port: int) -> bool:
    """Whether something answers at a port of this machine."""
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        probe.settimeout(0.5)
        return probe.connect_ex(("127.0.0.1", port)) == 0


def served_at(lab: LoadedLab, device: str) -> str | None:
    """The address at which another command serves this lab file's device now; None if none does."""
    if lab.path is None:
        return None  # the simulated lab is each run's own
    live = (words for folder in serving_folders(lab) for _, words in live_servers(folder))
    return next((str(words["url"]) for words in live if device in words["devices"]), None)


def holder_of(port: int) -> str | None:
    """Which devices `labrun serve` has at a port of this machine, of which lab, by which process."""
    for home in _homes().glob("*"):
        for path, words in (found for folder in _folders(home) for found in live_servers(folder)):
            if str(words["url"]).endswith(f":{port}"):
                lab, where = home.name.rpartition("-")[0] or home.name, ""
                with contextlib.suppress(OSError, ValueError, KeyError):
                    where = f" in {json.loads(path.with_name(SETTINGS).read_bytes())['base']}"
                served = ", ".join(words["devices"])
                return f"{served} of the lab {lab!r}{where} (process {words.get('owner')})"
    return None


def live_servers(folder: Path) -> Iterator[tuple[Path, dict[str, Any]]]:
    """Each server that lives in a folder: its file, and what that says of it."""
    for path in (*folder.glob(FILE), *folder.glob(f"*/{FILE}")):
        try:
            words = json.loads(path.read_bytes())
            if alive(words["pid"]) and {"url", "devices"} <= words.keys():
                yield path, words
        except (OSError, ValueError, KeyError, TypeError):
            continue  # it is being written, or its server has just ended
