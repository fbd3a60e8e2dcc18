"""Protocols as files in one folder: read and saved with revisions, deleted into a trash."""

import secrets
import shutil
import time
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path

from ...engine.run.folder import JOURNAL
from ...system.files import remove, write_whole
from ..local.clock import iso
from ..local.refusal import Refusal, Refused, not_found
from ..models.protocols import (
    LARGEST_TEXT,
    ProtocolText,
    SaveConflict,
    SavedProtocol,
    Thrown,
    Version,
)
from .names import DEEPEST, SUFFIXES, place_of, wrong_name
from .versions import KeptVersions

MOST_FILES = 2000


class Library:
    """The protocols in `folder`; `state` holds versions and trash."""

    def __init__(self, folder: Path, state: Path, runs: Path) -> None:
        self.folder = folder
        self._runs = runs
        self._trash = state / "trash"
        self._kept = KeptVersions(state / "versions")

    def names(self) -> list[str]:
        """Every file that could be a protocol, sorted; folders of runs are left out."""
        found: list[str] = []
        for path in self._walk(self.folder, 1):
            if len(found) >= MOST_FILES:
                break
            name = path.relative_to(self.folder).as_posix()
            if not wrong_name(name):
                found.append(name)
        return sorted(found)

    def _walk(self, folder: Path, depth: int) -> Iterator[Path]:
        try:
            inside = sorted(folder.iterdir())
        except OSError:
            return
        if any(path.name == JOURNAL for path in inside):
            return
        for path in inside:
            if path.name.startswith((".", "node_modules")) or path == self._runs:
                continue
            if path.is_dir() and not path.is_symlink() and depth < DEEPEST:
                yield from self._walk(path, depth + 1)
            elif path.suffix.lower() in SUFFIXES and path.is_file():
                yield path

    def read(self, name: str) -> ProtocolText:
        """The text of a protocol; its revision is kept, so that a conflict can show it later."""
        data, modified_ns = self._data(name)
        revision = revision_of(data)
        self._kept.keep(name, data, revision, modified_ns)
        return ProtocolText(
            name=name, text=_text(name, data), revision=revision, modified=iso(modified_ns / 1e9)
        )

    def save(self, name: str, text: str, base: str | None) -> SavedProtocol:
        """Save over the revision `base`; raises Refused with both texts if the file has another one."""
        path, data = place_of(self.folder, name), _bytes(text)
        if path.exists():
            before, before_ns = self._data(name)
            theirs = revision_of(before)
            if base != theirs and revision_of(data) != theirs:
                raise self._conflict(name, text, before, base)
            self._kept.keep(name, before, theirs, before_ns)
        elif base is not None:
            raise Refusal(
                404, "GONE", f"{name} no longer exists: it was deleted or renamed",
                "save it under a new name, or restore it from the trash",
            )  # fmt: skip
        return self._write(name, path, data)

    def create(self, name: str, text: str) -> ProtocolText:
        """A new file; raises Refusal (409) if it exists."""
        path = place_of(self.folder, name)
        if path.exists():
            raise Refusal(409, "EXISTS", f"{name} already exists", "choose another name")
        self._write(name, path, _bytes(text))
        return self.read(name)

    def versions(self, name: str) -> list[Version]:
        """The present text and the earlier ones, newest first."""
        data, modified_ns = self._data(name)
        current = revision_of(data)
        self._kept.keep(name, data, current, modified_ns)
        return [
            Version(
                revision=one.revision, saved_at=one.saved_at, size=one.path.stat().st_size,
                current=one.revision == current,
            )
            for one in self._kept.all(name)
        ]  # fmt: skip

    def version(self, name: str, revision: str) -> ProtocolText:
        """An earlier text."""
        place_of(self.folder, name)
        data = self._kept.read(name, revision)
        if data is None:
            raise not_found("version", f"{name} {revision[:12]}")
        saved = next(one for one in self._kept.all(name) if one.revision == revision)
        return ProtocolText(
            name=name, text=_text(name, data), revision=revision, modified=saved.saved_at
        )

    def throw_away(self, name: str) -> Thrown:
        """Move a protocol into the trash."""
        data, modified_ns = self._data(name)
        self._kept.keep(name, data, revision_of(data), modified_ns)
        now_ns = time.time_ns()
        id = f"{now_ns}-{secrets.token_hex(3)}"
        write_whole(self._trash / id / name, data)
        try:
            remove(place_of(self.folder, name))
        except OSError as fault:
            shutil.rmtree(self._trash / id, ignore_errors=True)
            words = fault.strerror or str(fault)
            raise Refusal(507, "NOT_DELETED", f"{name} cannot be deleted: {words}") from fault
        return Thrown(id=id, name=name, thrown_at=iso(now_ns / 1e9), size=len(data))

    def trash(self) -> list[Thrown]:
        """Deleted protocols, newest first."""
        return [
            self._thrown(id, path) for id, path in sorted(self._trashed().items(), reverse=True)
        ]

    def restore(self, id: str) -> ProtocolText:
        """Restore one under its name."""
        path = self._trashed().get(id)
        if path is None:
            raise not_found("protocol in the trash", id)
        thrown = self._thrown(id, path)
        restored = self.create(thrown.name, _text(thrown.name, path.read_bytes()))
        shutil.rmtree(self._trash / id, ignore_errors=True)  # Windows may still hold it
        return restored

    def _trashed(self) -> dict[str, Path]:
        """Id -> the file; each is in a separate folder, under its old name."""
        found: dict[str, Path] = {}
        for folder in self._trash.iterdir() if self._trash.is_dir() else ():
            path = next((p for p in folder.rglob("*") if p.is_file() and p.name[0] != "."), None)
            if path is not None and folder.name.partition("-")[0].isdecimal():
                found[folder.name] = path
        return found

    def _thrown(self, id: str, path: Path) -> Thrown:
        name = path.relative_to(self._trash / id).as_posix()
        at_ns = int(id.partition("-")[0])
        return Thrown(id=id, name=name, thrown_at=iso(at_ns / 1e9), size=path.stat().st_size)

    def _data(self, name: str) -> tuple[bytes, int]:
        path = place_of(self.folder, name)
        try:
            data, modified_ns = path.read_bytes(), path.stat().st_mtime_ns
        except (FileNotFoundError, IsADirectoryError, NotADirectoryError):
            raise not_found("protocol", name, "see the list of protocols") from None
        except OSError as fault:
            raise Refusal(422, "UNREADABLE", f"{name} cannot be read: {fault.strerror}") from fault
        return data, modified_ns

    def _write(self, name: str, path: Path, data: bytes) -> SavedProtocol:
        try:
            write_whole(path, data)
            modified_ns = path.stat().st_mtime_ns
        except OSError as fault:
            words = fault.strerror or str(fault)
            raise Refusal(
                507, "NOT_WRITTEN", f"{name} cannot be written: {words}", "your text is unchanged"
            ) from fault
        revision = revision_of(data)
        self._kept.keep(name, data, revision, modified_ns)
        return SavedProtocol(name=name, revision=revision, modified=iso(modified_ns / 1e9))

    def _conflict(self, name: str, mine: str, theirs: bytes, base: str | None) -> Refused:
        known = self._kept.read(name, base) if base is not None else None
        return Refused(
            409,
            SaveConflict(
                code="CONFLICT", message=f"{name} was saved by another user since you read it",
                hint="merge both texts, and save over the new revision",
                mine=mine, theirs=_text(name, theirs), theirs_revision=revision_of(theirs),
                base=None if known is None else _text(name, known),
            ),
        )  # fmt: skip


def revision_of(data: bytes) -> str:
    """The sha256 of a text's bytes."""
    return sha256(data).hexdigest()


def _bytes(text: str) -> bytes:
    try:
        data = text.encode("utf-8")
    except UnicodeEncodeError:
        raise Refusal(
            422, "NOT_TEXT", "the text contains half a character (a lone surrogate)"
        ) from None
    if len(data) > LARGEST_TEXT:
        raise Refusal(
            413, "TOO_LARGE", f"{len(data):,} bytes; at most {LARGEST_TEXT:,} are allowed"
        )
    return data


def _text(name: str, data: bytes) -> str:
    if len(data) > LARGEST_TEXT:
        raise Refusal(
            413,
            "TOO_LARGE",
            f"{name} has {len(data):,} bytes; at most {LARGEST_TEXT:,} are allowed",
        )
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        raise Refusal(422, "NOT_TEXT", f"{name} is not UTF-8 text") from None
