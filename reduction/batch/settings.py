"""How to reduce the spectra of a batch: sent to every worker."""

from dataclasses import dataclass

from ..lines.formula import Closed
from ..spectrum.axis import Unit
from ..spectrum.spectrum import Medium


@dataclass(frozen=True, slots=True)
class Settings:
    """elements: those requested, None for the usual ones and a row for all. medium None: decided.

    unit: of the wavelengths in the files, None as they say. columns: which to read, None as they
    say. lines: the text of a CSV file of lines of one's own, None for those shipped alone. response:
    the text of a CSV file of the instrument's response, None if none is to be divided out.
    calibration: the text of a file of `labrun calibrate standards`, None for areas alone. closure:
    what is closed to 100 % for concentrations without standards, None for none.
    """

    elements: tuple[str, ...] | None = None
    medium: Medium | None = None
    unit: Unit | None = None
    columns: tuple[str, ...] | None = None
    lines: str | None = None
    response: str | None = None
    calibration: str | None = None
    closure: Closed | None = None
