"""The complete bytes of a spectrum: a file that is still growing is refused; gzip is unpacked."""

import zlib
from pathlib import Path

from .fault import Unreadable

GZIP = b"\x1f\x8b\x08"
MOST_BYTES = 2**30


def bytes_of(source: Path | str | bytes) -> bytes:
    """The contents of a file, or the bytes themselves.

    Raises Unreadable if the file's size changes meanwhile (half a number would be a wrong one), or
    for a folder; OSError if the file cannot be opened.
    """
    if isinstance(source, bytes):
        return source
    path = Path(source)
    if path.is_dir():
        raise Unreadable(f"{path.name or path} is a folder; a spectrum is a file")
    before = path.stat().st_size
    raw = path.read_bytes()
    if not before == len(raw) == path.stat().st_size:
        raise Unreadable(f"{path.name} is still being written; read it again when it is complete")
    return raw


def beginning_of(path: Path, n: int) -> bytes:
    """The first `n` bytes at most, unpacked. Raises Unreadable if a gzip file is damaged, OSError."""
    with path.open("rb") as file:
        raw = file.read(n)
    if not raw.startswith(GZIP):
        return raw
    try:
        return zlib.decompressobj(wbits=31).decompress(raw, n)
    except zlib.error as fault:
        raise Unreadable(f"the gzip file is damaged ({fault}); copy it again") from None


def unpacked(raw: bytes) -> bytes:
    """The bytes, or what they hold if they are gzip. Raises Unreadable if that is cut off."""
    found = b""
    while raw.startswith(GZIP):
        unpack = zlib.decompressobj(wbits=31)
        try:
            found += unpack.decompress(raw, MOST_BYTES)
        except zlib.error as fault:
            raise Unreadable(f"the gzip file is damaged ({fault}); copy it again") from None
        if unpack.unconsumed_tail:
            raise Unreadable(
                f"the gzip file holds more than {MOST_BYTES:,} bytes: no spectrum does"
            )
        if not unpack.eof:
            raise Unreadable("the gzip file ends before its end: was it copied completely?")
        raw = unpack.unused_data
        if not raw.startswith(GZIP):
            return found
    return found or raw
