"""Copies of exported spectra, kept beside the book: an export that is asked for again costs nothing."""

import os
from hashlib import sha256
from pathlib import Path


class Kept:
    """One file a shot; it is there whole or not at all."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def keep(self, shot: str, data: bytes) -> str:
        """Write a spectrum through to the disk; its SHA-256. Raises OSError where there is no room."""
        fresh = self.folder / f".{shot}.{os.getpid()}"
        try:
            with fresh.open("wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            fresh.replace(self.folder / f"{shot}.csv")
        except OSError:
            fresh.unlink(missing_ok=True)
            raise
        return sha256(data).hexdigest()

    def read(self, shot: str, digest: str) -> bytes | None:
        """The spectrum of a shot; None where it is gone or not what was kept."""
        try:
            data = (self.folder / f"{shot}.csv").read_bytes()
        except OSError:
            return None
        return data if sha256(data).hexdigest() == digest else None
