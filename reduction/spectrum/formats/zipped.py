"""A zip archive is known by the name of its first file, which stands in its beginning."""

ZIP = b"PK\x03\x04"
NAME_AT = 30


def first_name(raw: bytes) -> str:
    """Of the first file in an archive; empty for no archive."""
    if not raw.startswith(ZIP):
        return ""
    n = int.from_bytes(raw[26:28], "little")
    return raw[NAME_AT : NAME_AT + n].decode("latin-1")
