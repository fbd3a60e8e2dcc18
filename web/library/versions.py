"""Earlier texts of protocols, kept by revision, the newest two hundred of each protocol."""

from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from urllib.parse import quote

from ...system.files import remove, write_whole
from ..local.clock import iso

MOST = 200
LONGEST = 200


@dataclass(frozen=True, slots=True)
class KeptVersion:
    """One stored text, and when it was current."""

    revision: str
    saved_ns: int
    path: Path

    @property
    def saved_at(self) -> str:
        """As ISO 8601, UTC."""
        return iso(self.saved_ns / 1e9)


class KeptVersions:
    """The texts of all protocols, one folder per name."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def keep(self, name: str, data: bytes, revision: str, saved_ns: int) -> None:
        """Keep a text unless it is already kept; the oldest are dropped."""
        known = self.all(name)
        if any(one.revision == revision for one in known):
            return
        write_whole(self._of(name) / f"{saved_ns:020}_{revision}", data)
        for old in known[MOST - 1 :]:
            remove(old.path)

    def all(self, name: str) -> list[KeptVersion]:
        """The versions of a name, newest first."""
        folder = self._of(name)
        if not folder.is_dir():
            return []
        found = []
        for path in folder.iterdir():
            when, mark, revision = path.name.partition("_")
            if mark and when.isdecimal():
                found.append(KeptVersion(revision, int(when), path))
        return sorted(found, key=lambda one: one.saved_ns, reverse=True)

    def read(self, name: str, revision: str) -> bytes | None:
        """The text of a revision; None if it is not kept."""
        return next(
            (one.path.read_bytes() for one in self.all(name) if one.revision == revision), None
        )

    def _of(self, name: str) -> Path:
        plain = quote(name, safe="")
        if len(plain) > LONGEST:  # many non-ASCII characters, each encoded as nine letters
            plain = f"{plain[:100]}%-{sha256(name.encode()).hexdigest()[:24]}"
        return self._folder / plain
