"""The text of a file, or the reason why it cannot be read."""

import codecs
import re
from dataclasses import dataclass
from pathlib import Path

from .yaml_lines import Lines

LARGEST = 10_000_000
"""Bytes; a protocol of a thousand lines has forty thousand."""
MARKS = (
    (codecs.BOM_UTF32_LE, "UTF-32"), (codecs.BOM_UTF32_BE, "UTF-32"),
    (codecs.BOM_UTF16_LE, "UTF-16"), (codecs.BOM_UTF16_BE, "UTF-16"),
)  # fmt: skip
KINDS = (
    (b"PK\x03\x04", "a ZIP file, such as Word and Excel save"), (b"%PDF", "a PDF"),
    (b"\x1f\x8b", "a gzip file"), (b"\x89PNG", "a picture"), (b"\xff\xd8\xff", "a picture"),
    (b"\xd0\xcf\x11\xe0", "an old Word or Excel file"), (b"{\\rtf", "an RTF file"),
)  # fmt: skip
SAVE = "save it as plain text with the encoding UTF-8"


@dataclass(frozen=True, slots=True)
class Unread:
    """Why there is no text: message, hint, problem code and place."""

    message: str
    hint: str = ""
    code: str = "E100"
    line: int = 1
    column: int = 1


def file_text(path: Path) -> str | Unread:
    """The text of a file; a file that is too large is not read at all."""
    try:
        if path.is_dir():
            return Unread("this is a folder, not a file", _inside(path))
        if not path.is_file():
            return _missing(path)
        size = path.stat().st_size
        if size > LARGEST:
            message = f"the file has {size:,} bytes; the limit is {LARGEST:,}"
            return Unread(message, "if it holds data, put the table in a CSV file", "E108")
        data = path.read_bytes()
    except PermissionError:
        return Unread("the file cannot be read: permission denied", "ask its owner for permission")
    except (OSError, ValueError) as fault:
        return Unread(f"the file cannot be read: {getattr(fault, 'strerror', None) or fault}")
    return decoded(data)


def decoded(data: bytes) -> str | Unread:
    """Bytes as text, if they are UTF-8; otherwise a guess at what they are."""
    if what := next((what for start, what in KINDS if data.startswith(start)), None):
        return Unread(f"this is {what}, not a text file", SAVE)
    if (name := _wide(data)) is not None:
        return Unread(f"the file is {name}, not UTF-8", SAVE)
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as fault:
        return _not_utf8(data, fault.start)


def _wide(data: bytes) -> str | None:
    """UTF-16 or UTF-32, recognised by its mark or by the zeros between Latin letters."""
    for mark, name in MARKS:
        if data.startswith(mark):
            return name
    if re.match(rb"(?:[\t\n\r -~]\x00){2}|(?:\x00[\t\n\r -~]){2}", data):
        return "UTF-16"
    return None


def _not_utf8(data: bytes, start: int) -> Unread:
    before = data[:start].decode("utf-8")
    line, column = Lines(before).place(len(before))
    byte = data[start : start + 1]
    guess = byte.decode("cp1252", "replace")
    if b"\0" in data:
        return Unread("this is not a text file", SAVE, line=line, column=column)
    if not guess.isprintable() or guess == "\ufffd":
        message = f"the file is not UTF-8 text: byte 0x{byte.hex().upper()} is invalid"
        return Unread(message, SAVE, line=line, column=column)
    message = (
        f"the file is not UTF-8 text; it looks like Latin-1 (Windows-1252), "
        f"where byte 0x{byte.hex().upper()} is {guess}"
    )
    return Unread(message, SAVE, line=line, column=column)


def _inside(folder: Path) -> str:
    """A hint naming a protocol in the folder, if there is one, or what goes on with the run that it is of."""
    if (folder / "journal.jsonl").is_file():
        return f"it is a run's: `labrun resume {folder}` goes on with it"
    found = sorted(entry for entry in folder.iterdir() if entry.suffix in (".yaml", ".yml"))
    return f"name a file in it, such as {found[0]}" if found else ""


def _missing(path: Path) -> Unread:
    from .suggest import closest

    if path.exists() or path.name == "-":
        return Unread("this is not a plain file", "save it as a file first")
    if path.is_symlink():
        return Unread(
            f"this is a link to {path.readlink()}, and there is no such file", "make it anew"
        )
    if not path.parent.is_dir():
        return Unread("there is no such file", f"there is no folder {path.parent} either")
    # By the stem: all that bench.yaml shares with bad.yaml is what every protocol ends in.
    ends = path.suffix.casefold()
    entries = [entry for entry in path.parent.iterdir() if entry.suffix.casefold() == ends]
    stems = {entry.stem: entry.name for entry in entries}
    near = closest(path.stem, stems)
    if there := stems[near] if near else _other_suffix(path):
        return Unread("there is no such file", f"did you mean {path.parent / there}?")
    files = sorted(entry.name for entry in entries if entry.is_file())
    return Unread("there is no such file", _what_there_is(path, files))


def _what_there_is(path: Path, names: list[str]) -> str:
    folder = "this folder" if path.parent == Path() else str(path.parent)
    if not names:
        return f"{folder} has no {path.suffix or 'such'} file; `labrun new {path.stem}` writes a protocol"
    more = f" and {len(names) - 3} more" if len(names) > 3 else ""
    return f"{folder} has {', '.join(names[:3])}{more}"


def _other_suffix(path: Path) -> str | None:
    for suffix in (".yaml", ".yml", ".json"):
        if path.with_suffix(suffix).is_file():
            return path.with_suffix(suffix).name
    return None
