"""Spectra of runs as Float32: each file is read once, shared wavelengths are sent once."""

from collections import OrderedDict
from dataclasses import dataclass
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from threading import Lock
from typing import Any

from ..local.refusal import Refusal

REDUCTION = "labrun.reduction"
KEPT_BYTES = 96 * 1024 * 1024
SUFFIXES = (".csv", ".tsv", ".txt")


@dataclass(frozen=True, slots=True)
class Read:
    """A spectrum: counts and the id of its wavelengths; `tag` changes when the file does."""

    tag: str
    axis: str
    counts: bytes


class SpectrumCache:
    """Keeps what was read, up to a number of bytes; may be used from several threads."""

    def __init__(self) -> None:
        self._read: OrderedDict[str, Read] = OrderedDict()
        self._axes: dict[str, bytes] = {}
        self._bytes = 0
        self._lock = Lock()

    def read(self, path: Path) -> Read:
        """A spectrum; raises Refusal if the file is not one."""
        try:
            stat = path.stat()
            tag = sha256(f"{path}\0{stat.st_size}\0{stat.st_mtime_ns}".encode()).hexdigest()[:24]
            with self._lock:
                if tag in self._read:
                    self._read.move_to_end(tag)
                    return self._read[tag]
            spectrum = import_module(REDUCTION).read_spectrum(path)
        except FileNotFoundError:
            raise Refusal(404, "NOT_FOUND", f"there is no file {path.name}") from None
        except (OSError, ValueError) as fault:
            raise Refusal(422, "NO_SPECTRUM", f"{path.name} is not a spectrum: {fault}") from fault
        return self._keep(tag, spectrum)

    def _keep(self, tag: str, spectrum: Any) -> Read:
        wavelengths = spectrum.wavelength_nm.astype("<f4").tobytes()
        axis = sha256(wavelengths).hexdigest()[:16]
        read = Read(tag, axis, spectrum.intensity.astype("<f4").tobytes())
        with self._lock:
            self._axes[axis] = wavelengths
            if tag not in self._read:
                self._read[tag] = read
                self._bytes += len(read.counts)
            while self._bytes > KEPT_BYTES and len(self._read) > 1:
                _, old = self._read.popitem(last=False)
                self._bytes -= len(old.counts)
        return read

    def axis(self, id: str) -> bytes | None:
        """The wavelengths of an id, Float32; None if no spectrum with them was read."""
        return self._axes.get(id)

    def mean(self, paths: list[Path]) -> tuple[str, bytes, int]:
        """Axis, mean counts, number of spectra; those with other wavelengths than the first are left out."""
        import numpy as np

        total: Any = None
        axis, count = "", 0
        for path in paths:
            read = self.read(path)
            if total is None:
                axis = read.axis
                total = np.zeros(len(read.counts) // 4)
            if read.axis == axis:
                total += np.frombuffer(read.counts, "<f4")
                count += 1
        if total is None:
            raise Refusal(404, "NO_SPECTRUM", "none of these points has a spectrum")
        return axis, (total / count).astype("<f4").tobytes(), count
