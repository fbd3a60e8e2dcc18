"""The newest mark of a ledger, where a backup of the ledger's folder does not put it back.

The ledgers of a user share a file in the system's folder for temporary files, in which each has a slot.
It is written without a sync: it outlives a killed server, and a restart of the computer may lose it.
Of two ledgers with one slot the later has it. Where it is not known, the ledger is believed as it is.
"""

import os
import tempfile
from contextlib import suppress
from io import FileIO
from pathlib import Path
from zlib import crc32

SLOTS, SLOT = 4096, 64


class NewestMark:
    """Of one ledger; nothing that goes wrong with it keeps a server from working."""

    def __init__(self, ledger: str, *, on_disk: bool = True) -> None:
        self._start = f"{ledger}:"
        self._at = crc32(ledger.encode()) % SLOTS * SLOT
        self._file: FileIO | None = None
        with suppress(OSError):  # it is another user's, or the disk is full
            self._file = _open() if on_disk else None

    def read(self) -> str:
        """As it was written last; empty where that is not known."""
        with suppress(OSError, UnicodeDecodeError):
            if self._file is not None:
                self._file.seek(self._at)
                found = (self._file.read(SLOT) or b"").rstrip(b"\0 ").decode("ascii")
                return found if found.startswith(self._start) else ""
        return ""

    def write(self, mark: str) -> None:
        """In one piece, before anybody is told it."""
        with suppress(OSError):
            if self._file is not None:
                self._file.seek(self._at)
                self._file.write(mark.encode().ljust(SLOT)[:SLOT])

    def close(self) -> None:
        """Leave it to the ledger's next server."""
        if self._file is not None:
            self._file.close()


def _open() -> FileIO:
    user = os.getuid() if hasattr(os, "getuid") else ""
    path = Path(tempfile.gettempdir()) / f"labrun_marks_{user}"
    flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    file = FileIO(os.open(path, flags, 0o600), "r+")
    if user != "" and os.fstat(file.fileno()).st_uid != user:
        file.close()
        raise PermissionError(f"{path} is another user's")
    return file
