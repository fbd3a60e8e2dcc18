"""The file that shows that a folder already has a device server."""

import contextlib
import json
import os
from hashlib import sha256
from pathlib import Path

from ...system.files import remove, write_whole
from .settings import ServerSettings

FILE = "server.json"
SETTINGS = "server_settings.json"
"""Beside it, from whoever started the server."""


class ServerFile:
    """One server's entry, from its start to its orderly shutdown; a kill leaves it behind."""

    def __init__(self, settings: ServerSettings, boot: str, url: str) -> None:
        self.path = Path(settings.folder) / FILE
        self.boot = boot
        self.words = {
            "pid": os.getpid(),
            "url": url,
            "boot": boot,
            "devices": list(settings.devices),
            "settings": fingerprint(settings),
            "owner": settings.owner_pid,
        }

    def announce(self) -> None:
        """Write it completely or not at all."""
        write_whole(self.path, json.dumps(self.words).encode(), sync=False)

    def leave(self) -> None:
        """Remove it, unless a later server wrote its own."""
        with contextlib.suppress(OSError, ValueError):
            if json.loads(self.path.read_bytes())["boot"] == self.boot:
                remove(self.path)


def fingerprint(settings: ServerSettings) -> str:
    """Equal for servers that would serve the same, whoever started them and wherever."""
    told = settings.model_dump(exclude={"owner_pid", "port", "patient"})
    return sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()
