"""Reduce one file of a batch to the rows of its tables; what is wrong with it is a row, too."""

import hashlib
import time
from dataclasses import dataclass
from pathlib import Path

from ..fault import Unreadable
from .settings import Settings
from .settle import settle


@dataclass(frozen=True, slots=True)
class Done:
    """What became of one file: its packed rows, and what the summary tells of it.

    reason: why it was not reduced, or empty. seconds: of a clock on the wall, reading included.
    """

    name: str
    reason: str = ""
    sha256: str = ""
    size: int = 0
    seconds: float = 0.0
    n_peaks: int = 0
    detected: tuple[str, ...] = ()
    uncertain: tuple[str, ...] = ()
    temperature_k: float | None = None
    rows: bytes = b""


def reduce_file(name: str, path: Path, settings: Settings) -> Done:
    """Read the file and reduce it; never raises for what is wrong with the file."""
    began = time.perf_counter()
    raw = load(path)
    return failed(name, raw) if isinstance(raw, str) else reduce_bytes(name, raw, settings, began)


def load(path: Path) -> bytes | str:
    """What the file holds, or why it cannot be read."""
    from ..source import bytes_of

    try:
        if path.exists() and not path.is_file():
            return f"{path.name} is no file that could be read to its end"
        if not settle(path):
            return f"{path.name} is still growing; reduce it again when it is complete"
        return bytes_of(path)
    except Unreadable as fault:
        return str(fault)
    except OSError as fault:
        return f"{path.name} cannot be opened: {fault.strerror or fault}"


def failed(name: str, reason: str, raw: bytes | None = None) -> Done:
    """A file that gave nothing but a reason."""
    from ..tables.file_rows import failed_row
    from ..tables.rows import packed

    one_line = " ".join(reason.split())
    rows = packed({"files": failed_row(one_line)})
    sha256, size = ("", 0) if raw is None else _known(raw)
    return Done(name, one_line, sha256, size, rows=rows)


def reduce_bytes(name: str, raw: bytes, settings: Settings, began: float | None = None) -> Done:
    """Reduce what a file holds; a fault of our own is told as one, and the batch goes on."""
    began = time.perf_counter() if began is None else began
    try:
        return _reduced(name, raw, settings, began)
    except (Unreadable, ValueError) as fault:
        return failed(name, str(fault), raw)
    except MemoryError:
        return failed(name, f"there was not enough memory for its {len(raw):,} bytes", raw)
    except Exception as fault:
        return failed(name, f"a fault in labrun itself: {type(fault).__name__}: {fault}", raw)


def _reduced(name: str, raw: bytes, settings: Settings, began: float) -> Done:
    from ..read import read_spectrum
    from ..reduce import reduce_spectrum
    from ..tables.rows import packed, rows_of

    spectrum = read_spectrum(raw, settings.unit)
    reduction = reduce_spectrum(spectrum, settings.elements, settings.medium)
    rows = packed(rows_of(spectrum, reduction, settings.elements))
    said = reduction.evidence.values()
    return Done(
        name, "", *_known(raw), time.perf_counter() - began, reduction.n_peaks,
        tuple(sorted(reduction.detected)),
        tuple(sorted(found.element for found in said if found.status == "uncertain")),
        reduction.temperature_k, rows,
    )  # fmt: skip


def _known(raw: bytes) -> tuple[str, int]:
    return hashlib.sha256(raw).hexdigest(), len(raw)
