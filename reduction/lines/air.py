"""Convert wavelengths between vacuum and standard air, on one scale throughout.

Standard air is dry, at 15 C and 101,325 Pa with 450 ppm CO2. The refractive index is
Ciddor, Applied Optics 35, 1566 (1996), equation 1, whose form and coefficients follow the
measurements of Peck and Reeder (J. Opt. Soc. Am. 62, 958 (1972)), from 185 nm on.

Tables print vacuum wavelengths below 200 nm and air wavelengths above. No spectrometer does: its
polynomial was fitted to a lamp's lines in air, and goes on below. So here air is air there, too.
"""

import numpy as np

from ..spectrum.spectrum import FloatArray, Medium

INDEX_BEGINS_NM = 185.0  # below, the index is that of 185 nm: air lets no light pass
INDEX_TERMS = 0.05792105, 238.0185, 0.00167917, 57.362  # Ciddor's, per um2


def refractive_index(vacuum_nm: FloatArray) -> FloatArray:
    """Refractive index of standard air at vacuum wavelengths in nm, any shape (Ciddor 1996)."""
    squared = (1000.0 / np.maximum(vacuum_nm, INDEX_BEGINS_NM)) ** 2  # wavenumber in 1/um, squared
    a, b, c, d = INDEX_TERMS
    return 1.0 + a / (b - squared) + c / (d - squared)


def to_air(vacuum_nm: FloatArray) -> FloatArray:
    """Air wavelengths of vacuum wavelengths, both nm, any shape."""
    vacuum_nm = np.asarray(vacuum_nm, dtype=np.float64)
    return vacuum_nm / refractive_index(vacuum_nm)


def to_vacuum(air_nm: FloatArray) -> FloatArray:
    """Vacuum wavelengths of air wavelengths, both nm, any shape; accurate to 1e-9 nm."""
    air_nm = np.asarray(air_nm, dtype=np.float64)
    vacuum_nm = air_nm
    for _ in range(4):  # the index changes so slowly that each turn gains three digits or more
        vacuum_nm = air_nm * refractive_index(vacuum_nm)
    return vacuum_nm


def in_medium(vacuum_nm: FloatArray, medium: Medium) -> FloatArray:
    """Vacuum wavelengths as an instrument shows them, nm. Raises ValueError on other media."""
    if medium == "vacuum":
        return np.asarray(vacuum_nm, dtype=np.float64)
    if medium == "air":
        return to_air(vacuum_nm)
    raise ValueError(f"medium is 'air' or 'vacuum', not {medium!r}")
