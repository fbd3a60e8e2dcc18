"""A run's folder as a zip that is made while it is sent, without its lab's secrets."""

import io
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

from ...engine.language.yaml_write import write_yaml
from ...engine.run.folder import LAB
from ...schemas.lab import without_secrets
from ..report.files import is_working, walk

PIECE = 256 * 1024
LEVEL = 1
"""Spectra as text: a seventh of the time of the usual level, for a fifth more bytes."""
PACKED = {".png", ".jpg", ".jpeg", ".zip", ".gz", ".npz", ".h5", ".pdf", ".tif"}


class _Sink(io.RawIOBase):
    """Buffers what the zip writes until it is fetched."""

    def __init__(self) -> None:
        self._pieces: list[bytes] = []

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int:
        self._pieces.append(bytes(data))
        return len(data)

    def fetched(self) -> bytes:
        """Everything since the last fetch."""
        data, self._pieces = b"".join(self._pieces), []
        return data


def zipped(folder: Path) -> Iterator[bytes]:
    """The zip in pieces; a file that cannot be read is left out, and listed in `LEFT-OUT.txt`."""
    sink, left_out = _Sink(), []
    with zipfile.ZipFile(sink, "w", zipfile.ZIP_DEFLATED, compresslevel=LEVEL) as archive:
        for name in walk(folder):
            if is_working(name):
                continue
            try:
                yield from _file(archive, sink, folder, name)
            except OSError as fault:
                left_out.append(f"{name}: {fault.strerror}")
        if left_out:
            archive.writestr(f"{folder.name}/LEFT-OUT.txt", "\n".join(left_out))
    yield sink.fetched()


def _file(archive: zipfile.ZipFile, sink: _Sink, folder: Path, name: str) -> Iterator[bytes]:
    path, inside = folder / name, f"{folder.name}/{name}"
    if Path(name).name == LAB:
        archive.writestr(inside, without_tokens(path.read_text(encoding="utf-8")))
        yield sink.fetched()
        return
    info = zipfile.ZipInfo.from_file(path, inside)
    packed = path.suffix.lower() in PACKED
    info.compress_type = zipfile.ZIP_STORED if packed else zipfile.ZIP_DEFLATED
    info._compresslevel = LEVEL  # type: ignore[attr-defined] # the archive's counts only for names
    with path.open("rb") as file, archive.open(info, "w") as target:
        while piece := file.read(PIECE):
            target.write(piece)
            yield sink.fetched()


def without_tokens(text: str) -> str:
    """A lab file without tokens, passwords, headers and logins; unchanged if there were none."""
    if not any(word in text for word in ("token", "password", "headers", "login")):
        return text
    data = YAML(typ="safe", pure=True).load(text)
    out = io.StringIO()
    write_yaml(without_secrets(data or {}), out)
    return "# tokens were removed\n" + out.getvalue()
