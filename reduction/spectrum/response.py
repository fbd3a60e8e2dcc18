"""The response of an instrument: what its counts are multiplied by along the axis, from a file."""

import csv
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from .spectrum import FloatArray, Spectrum

HEADING = ("wavelength_nm", "response", "error")
BLIND = 0.01  # of the greatest response: where there is less, counts say nothing
NEAR_NM = 0.5


class ResponseFault(ValueError):
    """A file of a response that cannot be used; the text says which line of it, and why."""


@dataclass(frozen=True, slots=True, eq=False)
class KnownResponse:
    """Counts per light, 1 at the most, and their relative standard error, at wavelengths in nm as
    the instrument gives them, ascending; all of shape (n,)."""

    wavelength_nm: FloatArray
    response: FloatArray
    error: FloatArray

    def at(self, nm: FloatArray) -> FloatArray:
        """Counts per light at wavelengths as the instrument gives them, any shape."""
        return np.exp(np.interp(nm, self.wavelength_nm, np.log(self.response)))

    def divided_out(self, spectrum: Spectrum) -> Spectrum:
        """The spectrum of the light: counts over response, bad where the response is below 1 %.

        Beyond the ends of the response its outermost values are taken, and a note says so.
        """
        x = spectrum.wavelength_nm
        at = self.at(x)
        blind = at < BLIND
        notes = [*spectrum.notes, "the instrument's response was divided out"]
        first, last = self.wavelength_nm[0], self.wavelength_nm[-1]
        if x[0] < first - NEAR_NM or x[-1] > last + NEAR_NM:
            notes.append(
                f"the response is known from {first:.0f} to {last:.0f} nm; beyond, it is taken as at the ends"
            )
        if blind.any():
            notes.append(
                f"{blind.sum():,} channels with less than 1 % of the greatest response are left out"
            )
        counts = np.where(blind, np.nan, spectrum.intensity / at)
        return replace(spectrum, intensity=counts, notes=tuple(notes), divided_by=self)


@lru_cache(maxsize=4)
def read_response(text: str) -> KnownResponse:
    """The response in a CSV file with columns wavelength_nm, response and, if known, error (a part
    of the response); lines that begin with # are comments. Raises ResponseFault."""
    lines = [
        (n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip() and line[0] != "#"
    ]
    if not lines:
        raise ResponseFault("it is empty")
    headings = [cell.strip() for cell in next(csv.reader([lines[0][1]]))]
    lacking = [name for name in HEADING[:2] if name not in headings]
    if lacking:
        raise ResponseFault(f"line {lines[0][0]}: no column {' and '.join(lacking)}")
    rows = []
    for number, line in lines[1:]:
        cells = dict(zip(headings, next(csv.reader([line])), strict=False))
        try:
            rows.append([float(cells.get(name) or "nan") for name in HEADING])
        except ValueError as fault:
            raise ResponseFault(f"line {number}: {fault}") from None
        if not (np.isfinite(rows[-1][:2]).all() and rows[-1][1] > 0):
            raise ResponseFault(
                f"line {number}: wavelength and response must be numbers, the response above 0"
            )
    nm, response, error = np.array(rows).reshape(-1, 3).T
    if len(nm) < 2 or not np.all(np.diff(nm) > 0):
        raise ResponseFault("it needs two wavelengths or more, in ascending order")
    return KnownResponse(nm, response / response.max(), error)


def write_response(found: KnownResponse, path: Path, card: list[str]) -> None:
    """The response as `read_response` reads it; `card`: comments that say where it is from."""
    rows = zip(found.wavelength_nm, found.response, found.error, strict=True)
    path.write_text(
        "".join(f"# {line}\n" for line in card)
        + ",".join(HEADING)
        + "\n"
        + "".join(f"{nm:.3f},{response:.6g},{error:.3g}\n" for nm, response, error in rows),
        encoding="utf-8",
    )
