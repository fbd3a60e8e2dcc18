"""Read a spectrum from the text that an analyser exports.

SciAps writes CSV with the header `wavelength,intensity`; a header, comment lines (#) before it,
and commas, semicolons, tabs or spaces between the columns are all accepted.
"""

import math
import re
from pathlib import Path

import numpy as np

from .axis import Unit, in_nm
from .fault import Unreadable
from .shots import NPY_MAGIC, read_shots
from .source import bytes_of
from .spectrum import Spectrum

BETWEEN = re.compile(r"\s*[,;\t]\s*|\s+")
BAD_CHANNEL = ("", "nan", "na", "null")
BYTE_ORDER_MARK = b"\xef\xbb\xbf"
SHOWN = 40  # characters of a faulty line shown in an error


def read_spectrum(source: Path | str | bytes, unit: Unit = "nm") -> Spectrum:
    """The spectrum in a file, or in the bytes of one.

    Wavelengths in nm, ascending (rows are sorted, equal wavelengths averaged); intensities in
    counts, NaN where the text has nan, inf or nothing. unit: of the wavelengths in the file.
    Several shots in .npy are averaged. Raises Unreadable for text that is empty, has one column,
    anything but numbers in it (with the line number), an axis that is not wavelengths in that
    unit, or only zeros; OSError if the file cannot be opened.
    """
    raw = bytes_of(source)
    if raw.startswith(NPY_MAGIC):
        return _with_light(read_shots(raw, unit).mean())
    text = raw.removeprefix(BYTE_ORDER_MARK)
    wavelength_nm, intensity = _columns(text, _after_header(text))
    if not len(wavelength_nm):
        raise Unreadable("the spectrum is empty: it has no row of wavelength and intensity")
    if not np.isfinite(intensity).any():
        raise Unreadable("the spectrum has no numeric intensity")
    return _with_light(Spectrum(*_ascending(in_nm(wavelength_nm, unit), intensity)))


def _with_light(spectrum: Spectrum) -> Spectrum:
    if not np.nanmax(np.abs(spectrum.intensity)) > 0:
        raise Unreadable("every intensity is 0: the detector was not read out")
    return spectrum


def _after_header(text: bytes) -> int:
    """Where the first line begins that is neither a comment nor the header."""
    at = 0
    while at < len(text):
        stop = text.find(b"\n", at)
        stop = len(text) if stop < 0 else stop + 1
        line = text[at:stop].strip()
        if line and not line.startswith(b"#"):
            is_header = line[:1].isalpha() or line[:1] == b'"'
            return stop if is_header and not line.lower().startswith(b"nan") else at
        at = stop
    return at


def _columns(text: bytes, at: int) -> tuple[np.ndarray, np.ndarray]:
    from .parse import pairs  # compiled: kept out of the import of this file

    n_most = text.count(b"\n") + 1
    first, second = np.empty(n_most), np.empty(n_most)
    array = np.frombuffer(text, dtype=np.uint8)
    n = 0
    while True:
        at, n = pairs(array, at, first, second, n)
        if at >= len(text):
            return first[:n], second[:n]
        stop = text.find(b"\n", at)
        stop = len(text) if stop < 0 else stop
        line_number = text.count(b"\n", 0, at) + 1
        first[n], second[n] = _odd_line(text[at:stop], line_number)
        at, n = stop + 1, n + 1


def _odd_line(line: bytes, line_number: int) -> tuple[float, float]:
    """Two numbers from a line that is not two plain numbers."""
    try:
        shown = line.decode("utf-8").strip()
    except UnicodeDecodeError:
        raise Unreadable(f"line {line_number} is not UTF-8 text; is this a CSV file?") from None
    fields = BETWEEN.split(shown)
    shown = shown[:SHOWN]
    if len(fields) < 2:
        raise Unreadable(
            f"line {line_number} has one column ({shown!r}); "
            "a spectrum has two, wavelength and intensity"
        )
    try:
        wavelength_nm = float(fields[0])
        intensity = math.nan if fields[1].lower() in BAD_CHANNEL else float(fields[1])
    except ValueError:
        raise Unreadable(f"line {line_number} is not two numbers: {shown!r}") from None
    if not math.isfinite(wavelength_nm):
        raise Unreadable(f"line {line_number} has no wavelength: {shown!r}")
    return wavelength_nm, intensity if math.isfinite(intensity) else math.nan


def _ascending(wavelength_nm: np.ndarray, intensity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    if np.all(np.diff(wavelength_nm) > 0):
        return wavelength_nm, intensity
    unique_nm, row = np.unique(wavelength_nm, return_inverse=True)
    good = np.isfinite(intensity)
    total = np.bincount(row[good], intensity[good], minlength=len(unique_nm))
    count = np.bincount(row[good], minlength=len(unique_nm))
    return unique_nm, np.divide(total, count, out=np.full(len(unique_nm), np.nan), where=count > 0)
