"""Where a lab's device is served now: where the lab names a server, or by `labrun serve`."""

import json
import socket
from collections.abc import Iterator
from hashlib import blake2b
from pathlib import Path
from typing import Any

from ...drivers.server.server_file import FILE
from ...schemas.lab import LabDevice
from ...system.files import write_whole
from ...system.process import alive
from ..lab.lab import LoadedLab


def serve_home(lab: LoadedLab) -> Path:
    """Where `labrun serve` keeps a lab's, wherever it is given: a device's ledger must be found again."""
    from platformdirs import user_state_path

    name = lab.served_as or "simulated"
    if lab.path is not None and not lab.served_as:
        path = lab.path.resolve()
        name = f"{path.stem}-{blake2b(str(path).encode(), digest_size=4).hexdigest()}"
    return user_state_path("labrun", appauthor=False) / "servers" / name


def remember(lab: LoadedLab, folder: Path) -> None:
    """That a lab is served from a folder of its own (`--folder`), so that runs and stops find it."""
    listed, known = _elsewhere(lab), _other_folders(lab)
    if folder not in known:
        listed.parent.mkdir(parents=True, exist_ok=True)
        kept = [str(one) for one in known if one.is_dir()]
        write_whole(listed, "\n".join([*kept, str(folder)]).encode(), mode=0o644, sync=False)


def _elsewhere(lab: LoadedLab) -> Path:
    home = serve_home(lab)
    return home.with_name(f"{home.name}.elsewhere")


def _other_folders(lab: LoadedLab) -> list[Path]:
    try:
        return [Path(line) for line in _elsewhere(lab).read_text("utf-8").splitlines()]
    except (OSError, ValueError):
        return []


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
    """The address at which `labrun serve` serves this lab file's device now; None if it does not."""
    if lab.path is None:
        return None  # the simulated lab is each run's own
    return next((str(w["url"]) for w in serving_lab(lab) if device in w["devices"]), None)


def serving_lab(lab: LoadedLab) -> Iterator[dict[str, Any]]:
    """What each server of `labrun serve` for this lab says of itself, wherever its folder is."""
    for _, words in live_servers(serve_home(lab)):
        yield words
    for folder in _other_folders(lab):
        for _, words in live_servers(folder, f"*/{FILE}"):
            yield words


def live_servers(
    folder: Path, pattern: str = f"**/{FILE}"
) -> Iterator[tuple[Path, dict[str, Any]]]:
    """Each server that lives in a folder: its file, and what that says of it."""
    for path in folder.glob(pattern):
        try:
            words = json.loads(path.read_bytes())
            if alive(words["pid"]) and {"url", "devices"} <= words.keys():
                yield path, words
        except (OSError, ValueError, KeyError, TypeError):
            continue  # it is being written, or its server has just ended
