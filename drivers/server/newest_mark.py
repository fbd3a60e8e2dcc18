"""The newest mark of a ledger, or of a run's journal, where a backup of its folder does not put it back.

Those of a user share a file in the system's folder for temporary files, in which each has a slot.
It is written without a sync: it outlives a killed process, and a restart of the computer may lose it.
Of two with one slot the later has it. Where it is not known, what is there is believed as it is.
"""

import os
import tempfile
from contextlib import suppress
from io import FileIO
from pathlib import Path
from zlib import crc32

SLOTS, SLOT = 4096, 64


class NewestMark:
    """Of one ledger or journal; nothing that goes wrong with it keeps a server or an engine from working."""

    def __init__(self, of: str, *, file: str = "marks", on_disk: bool = True) -> None:
        self._start = f"{of}:"
        self._at = crc32(of.encode()) % SLOTS * SLOT
        self._file: FileIO | None = None
        with suppress(OSError):  # it is another user's, or the disk is full
            self._file = _open(file) if on_disk else None

    def read(self) -> str:
        """As it was written last; empty where that is not known."""
        found = self._slot()
        return found if found is not None and found.startswith(self._start) else ""

    @property
    def is_blank(self) -> bool:
        """Whether nothing was ever written there: another computer, or the folder was emptied."""
        return self._slot() == ""

    def _slot(self) -> str | None:
        with suppress(OSError, UnicodeDecodeError):
            if self._file is not None:
                self._file.seek(self._at)
                return (self._file.read(SLOT) or b"").rstrip(b"\0 ").decode("ascii")
        return None

    def write(self, mark: str) -> None:
        """In one piece, before anybody is told it."""
        with suppress(OSError):
            if self._file is not None:
                self._file.seek(self._at)
                self._file.write(mark.encode().ljust(SLOT)[:SLOT])

    def close(self) -> None:
        """Leave it to who has the ledger, or the journal, next."""
        if self._file is not None:
            self._file.close()


def _open(name: str) -> FileIO:
    user = os.getuid() if hasattr(os, "getuid") else ""
    path = Path(tempfile.gettempdir()) / f"labrun_{name}_{user}"
    flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    file = FileIO(os.open(path, flags, 0o600), "r+")
    if user != "" and os.fstat(file.fileno()).st_uid != user:
        file.close()
        raise PermissionError(f"{path} is another user's")
    return file
