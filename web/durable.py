"""Write a file of the server's own state: whole or not at all, and on the disk when it returns."""

import os
import secrets
from pathlib import Path

from ..engine.run_files import sync_folder


def write_durable(path: Path, data: bytes, mode: int = 0o644) -> None:
    """Replace a file; raises OSError, and the old one is there still."""
    path.parent.mkdir(parents=True, exist_ok=True)
    half = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
    try:
        with os.fdopen(os.open(half, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        half.replace(path)
    except OSError:
        half.unlink(missing_ok=True)
        raise
    sync_folder(path.parent)
