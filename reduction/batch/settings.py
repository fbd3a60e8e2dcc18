"""How the spectra of a batch are to be reduced: what travels to every worker."""

from dataclasses import dataclass

from ..axis import Unit
from ..spectrum import Medium


@dataclass(frozen=True, slots=True)
class Settings:
    """elements: those asked for, None for the usual ones and a row for all. medium None: decided.

    unit: of the wavelengths in the files.
    """

    elements: tuple[str, ...] | None = None
    medium: Medium | None = None
    unit: Unit = "nm"
