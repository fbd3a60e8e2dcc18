"""The file that tells whoever starts a device server in a folder that there is one already."""

import contextlib
import json
import os
import sys
from hashlib import sha256
from pathlib import Path

from .settings import ServerSettings

FILE = "server.json"


class Presence:
    """One server's entry, from its start to its orderly end; a kill leaves it behind."""

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
        """Write it whole or not at all."""
        draft = self.path.with_suffix(".new")
        draft.write_text(json.dumps(self.words), encoding="utf-8")
        draft.replace(self.path)

    def leave(self) -> None:
        """Take it away, unless a later server wrote its own."""
        with contextlib.suppress(OSError, ValueError):
            if json.loads(self.path.read_bytes())["boot"] == self.boot:
                self.path.unlink()


def fingerprint(settings: ServerSettings) -> str:
    """Equal for servers that would serve the same: who started them, and where, does not count."""
    told = settings.model_dump(exclude={"owner_pid", "port"})
    return sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()


def alive(pid: int | None) -> bool:
    """True where a process is there and has not ended, as far as this system lets us ask."""
    # On Windows a signal of 0 would end the process instead of asking after it.
    if pid is None or sys.platform == "win32":
        return False
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return not _waits_for_its_parent(pid)


def _waits_for_its_parent(pid: int) -> bool:
    """A process that has ended and that nobody has asked about yet still has its number."""
    try:
        words = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return False
    return words.rpartition(")")[2].split()[:1] == ["Z"]
