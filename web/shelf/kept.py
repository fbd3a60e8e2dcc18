"""Earlier texts of protocols: each is kept under its revision, the newest two hundred of each."""

from dataclasses import dataclass
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path
from urllib.parse import quote

from ..durable import write_durable

MOST = 200
LONGEST = 200


@dataclass(frozen=True, slots=True)
class Kept:
    """One text that is kept, and when it was the present one."""

    revision: str
    saved_ns: int
    path: Path

    @property
    def saved_at(self) -> str:
        """As ISO 8601, UTC."""
        return iso(self.saved_ns)


class KeptTexts:
    """The texts of all protocols, a folder for each name."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def keep(self, name: str, data: bytes, revision: str, saved_ns: int) -> None:
        """Keep a text, unless it is kept already; the oldest make room."""
        known = self.all(name)
        if any(one.revision == revision for one in known):
            return
        write_durable(self._of(name) / f"{saved_ns:020}_{revision}", data)
        for old in known[MOST - 1 :]:
            old.path.unlink(missing_ok=True)

    def all(self, name: str) -> list[Kept]:
        """What is kept of a name, newest first."""
        folder = self._of(name)
        if not folder.is_dir():
            return []
        found = []
        for path in folder.iterdir():
            when, mark, revision = path.name.partition("_")
            if mark and when.isdecimal():
                found.append(Kept(revision, int(when), path))
        return sorted(found, key=lambda one: one.saved_ns, reverse=True)

    def read(self, name: str, revision: str) -> bytes | None:
        """The text of a revision; None where it is not kept."""
        return next(
            (one.path.read_bytes() for one in self.all(name) if one.revision == revision), None
        )

    def _of(self, name: str) -> Path:
        plain = quote(name, safe="")
        if len(plain) > LONGEST:  # many characters of other scripts, each of nine letters by now
            plain = f"{plain[:100]}%-{sha256(name.encode()).hexdigest()[:24]}"
        return self._folder / plain


def iso(time_ns: int) -> str:
    """Nanoseconds since 1970 as ISO 8601, UTC."""
    return datetime.fromtimestamp(time_ns / 1e9, UTC).isoformat(timespec="milliseconds")
