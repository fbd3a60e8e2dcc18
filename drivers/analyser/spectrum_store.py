"""Copies of exported spectra, stored beside the shot log: repeating an export costs nothing."""

from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path

from ...system.files import write_whole


class SpectrumStore:
    """One file per shot, complete or not there at all."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def keep(self, shot: str, data: bytes) -> str:
        """Sync a spectrum to disk and return its SHA-256. Raises OSError if the disk is full."""
        write_whole(self.folder / f"{shot}.csv", data)
        return sha256(data).hexdigest()

    def set_aside(self, folder: str, files: Mapping[str, bytes], why: str) -> Path:
        """Copy files that are nobody's proved spectrum, with a sentence; returns their folder."""
        place = self.folder.parent / "quarantine" / folder
        for path, data in files.items():
            write_whole(place / path.replace("/", "_"), data)
        write_whole(place / "why.txt", f"{why}\n".encode())
        return place

    def read(self, shot: str, digest: str) -> bytes | None:
        """The spectrum of a shot; None if it is gone or has changed since it was stored."""
        try:
            data = (self.folder / f"{shot}.csv").read_bytes()
        except OSError:
            return None
        return data if sha256(data).hexdigest() == digest else None
