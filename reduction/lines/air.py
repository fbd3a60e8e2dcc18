"""Convert wavelengths between vacuum and standard air.

Standard air is dry, at 15 C and 101,325 Pa with 450 ppm CO2. The refractive index is
Ciddor, Applied Optics 35, 1566 (1996), equation 1. By NIST's convention wavelengths below
200 nm in vacuum are given in vacuum, and neither function changes them.
"""

import numpy as np

from ..spectrum.spectrum import FloatArray, Medium

AIR_BEGINS_NM = 200.0
INDEX_TERMS = 0.05792105, 238.0185, 0.00167917, 57.362  # Ciddor's, per um2


def refractive_index(vacuum_nm: FloatArray) -> FloatArray:
    """Refractive index of standard air at vacuum wavelengths in nm, any shape (Ciddor 1996)."""
    squared = (1000.0 / vacuum_nm) ** 2  # wavenumber in 1/um, squared
    a, b, c, d = INDEX_TERMS
    return 1.0 + a / (b - squared) + c / (d - squared)


def to_air(vacuum_nm: FloatArray) -> FloatArray:
    """Air wavelengths of vacuum wavelengths, both nm, any shape."""
    vacuum_nm = np.asarray(vacuum_nm, dtype=np.float64)
    index = refractive_index(np.maximum(vacuum_nm, AIR_BEGINS_NM))
    return np.where(vacuum_nm < AIR_BEGINS_NM, vacuum_nm, vacuum_nm / index)


def to_vacuum(air_nm: FloatArray) -> FloatArray:
    """Vacuum wavelengths of air wavelengths, both nm, any shape; accurate to 1e-9 nm."""
    air_nm = np.asarray(air_nm, dtype=np.float64)
    begins_nm = AIR_BEGINS_NM / refractive_index(np.array(AIR_BEGINS_NM))
    seen_nm = np.maximum(air_nm, begins_nm)
    vacuum_nm = seen_nm
    for _ in range(3):  # the index changes so slowly that each turn gains four digits
        vacuum_nm = seen_nm * refractive_index(vacuum_nm)
    return np.where(air_nm < begins_nm, air_nm, vacuum_nm)


def in_medium(vacuum_nm: FloatArray, medium: Medium) -> FloatArray:
    """Vacuum wavelengths as an instrument shows them, nm. Raises ValueError on other media."""
    if medium == "vacuum":
        return np.asarray(vacuum_nm, dtype=np.float64)
    if medium == "air":
        return to_air(vacuum_nm)
    raise ValueError(f"medium is 'air' or 'vacuum', not {medium!r}")
