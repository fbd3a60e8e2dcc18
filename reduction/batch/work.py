"""Reduce one file of a batch to the rows of its tables; a failure becomes a row too."""

import hashlib
import logging
import time
from dataclasses import dataclass, replace
from pathlib import Path

from ..spectrum.fault import Unreadable
from .finished_file import wait_until_finished
from .settings import Settings

LOG = logging.getLogger("labrun")


@dataclass(frozen=True, slots=True)
class Done:
    """The result of one file: its packed rows, and its data for the summary.

    reason: why it was not reduced, or empty. seconds: wall-clock time, reading included. notes:
    what was noticed, as sentences.
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
    notes: tuple[str, ...] = ()
    rows: bytes = b""


def reduce_file(name: str, path: Path, settings: Settings) -> Done:
    """Read the file and reduce it; never raises for a fault of the file."""
    began = time.perf_counter()
    raw = load(path)
    return failed(name, raw) if isinstance(raw, str) else reduce_bytes(name, raw, settings, began)


def load(path: Path) -> bytes | str:
    """The file's contents, or why it cannot be read."""
    from ..spectrum.source import bytes_of

    try:
        if path.exists() and not path.is_file():
            return f"{path.name} is not a file that can be read to its end"
        if not wait_until_finished(path):
            return f"{path.name} is still growing; reduce it again when it is complete"
        return bytes_of(path)
    except Unreadable as fault:
        return str(fault)
    except OSError as fault:
        return f"{path.name} cannot be opened: {fault.strerror or fault}"


def failed(name: str, reason: str, raw: bytes | None = None) -> Done:
    """The result of a file that could not be reduced."""
    from ..tables.file_rows import failed_row
    from ..tables.rows import packed

    one_line = " ".join(reason.split())
    rows = packed({"files": failed_row(one_line)})
    sha256, size = ("", 0) if raw is None else _known(raw)
    return Done(name, one_line, sha256, size, rows=rows)


def reduce_bytes(name: str, raw: bytes, settings: Settings, began: float | None = None) -> Done:
    """Reduce a file's contents; an internal error is reported as one, and the batch continues."""
    began = time.perf_counter() if began is None else began
    try:
        return _reduced(name, raw, settings, began)
    except (Unreadable, ValueError) as fault:
        return failed(name, str(fault), raw)
    except MemoryError:
        return failed(name, f"not enough memory for its {len(raw):,} bytes", raw)
    except Exception as fault:  # ours: the other files are reduced, and the log has its traceback
        LOG.exception("%s was not reduced", name)
        return failed(name, f"an internal error in labrun: {type(fault).__name__}: {fault}", raw)


def _reduced(name: str, raw: bytes, settings: Settings, began: float) -> Done:
    from ..lines.lines import use_lines
    from ..reduce import reduce_spectrum
    from ..spectrum.read import of_one_sample, read_shots
    from ..spectrum.response import read_response
    from ..spectrum.spectrum import Spectrum
    from ..tables.rows import packed, rows_of

    use_lines(settings.lines)
    shots = read_shots(raw, settings.unit, settings.columns)
    if settings.columns is None:
        shots = of_one_sample(shots)

    def seen(one: Spectrum) -> Spectrum:
        text = settings.response
        return one if text is None else read_response(text).divided_out(one)

    spectrum, contents = seen(shots.mean()), None
    if settings.calibration is None and settings.closure is None:
        reduction = reduce_spectrum(spectrum, settings.elements, settings.medium)
    else:
        from ..calibration.calibration import read_calibration
        from ..calibration.reduced_shots import reduce_shots

        text, closed = settings.calibration, settings.closure
        known = read_calibration(text) if text is not None else closed
        assert known is not None
        found = reduce_shots(shots, known, settings.elements, settings.medium, seen)
        reduction = replace(found.reduction, notes=(*found.reduction.notes, *found.doubts))
        contents = found.contents
    rows = packed(rows_of(spectrum, reduction, settings.elements, contents))
    said = reduction.evidence.values()
    return Done(
        name, "", *_known(raw), time.perf_counter() - began, reduction.n_peaks,
        tuple(sorted(reduction.detected)),
        tuple(sorted(found.element for found in said if found.status == "uncertain")),
        reduction.temperature_k, reduction.notes, rows,
    )  # fmt: skip


def _known(raw: bytes) -> tuple[str, int]:
    return hashlib.sha256(raw).hexdigest(), len(raw)
