"""Air wavelengths one by one, for the loops that are compiled."""

from ..spectrum.kernel import kernel
from .air import INDEX_BEGINS_NM, INDEX_TERMS


@kernel
def in_air(vacuum_nm):
    """The air wavelength of one vacuum wavelength, both nm; as `air.to_air`."""
    squared = (1000.0 / max(vacuum_nm, INDEX_BEGINS_NM)) ** 2
    a, b, c, d = INDEX_TERMS
    return vacuum_nm / (1.0 + a / (b - squared) + c / (d - squared))
