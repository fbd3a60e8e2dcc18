"""Choose lines for the plasma diagnosis: matched, strong enough, and not blended."""

import numpy as np

from ..peaks.voigt import VoigtPeaks
from ..plasma.boltzmann import PlotLines
from ..plasma.strengths import atoms
from ..spectrum.spectrum import FloatArray
from .catalogue import Catalogue
from .index import Indexed
from .match import Matched

OWN = 0.8  # part of a peak's expected area that its line must have
RELATIVE = 0.35  # error of the area, as a part of it, up to which a line speaks
BEYOND = 1.6  # residual in ln(area) at which a match is a mistake


def plot_lines(
    peaks: VoigtPeaks,
    catalogue: Catalogue,
    log_area: FloatArray,
    matched: Matched,
    indexed: Indexed,
    response: FloatArray | float = 0.0,
    beyond: float = BEYOND,
) -> PlotLines:
    """The lines of the accepted elements for the Saha-Boltzmann plot.

    log_area: ln of the expected thin area for one atom, shape (entries,). response: ln of what the
    instrument makes of it. beyond: of ln(area), residual of a mistake.
    """
    a = atoms()
    entries = catalogue.entries_of(indexed.accepted)
    entries = entries[matched.peak[entries] >= 0]
    element = catalogue.element[entries]
    gain = response[entries] if isinstance(response, np.ndarray) else response
    expected = np.exp(log_area[entries] + gain + indexed.log_scale[element])
    peak = matched.peak[entries]
    total = np.bincount(peak, expected, len(peaks))
    area = np.maximum(peaks.area[peak], 1e-12)
    relative = peaks.area_error[peak] / area
    away = np.log(area / np.maximum(expected, 1e-300))
    good = (expected > OWN * total[peak]) & (relative < RELATIVE) & (np.abs(away) < beyond)
    good &= a.elements[element] != "H"  # too broad for its area to be sure
    return lines_of_entries(catalogue, entries[good], np.log(area[good]), relative[good])


def lines_of_entries(
    catalogue: Catalogue, entries: np.ndarray, log_area: FloatArray, relative: FloatArray
) -> PlotLines:
    """Entries of the catalogue with ln of their areas and its error, both (n,), as lines."""
    a = atoms()
    leader = catalogue.leader[entries]
    rows, entry = catalogue.rows_of(entries)
    return PlotLines(
        log_area,
        np.sqrt(relative**2 + a.uncertainty[leader] ** 2),
        a.element[leader],
        rows,
        entry,
        a.wavelength_nm[leader],
        a.width_nm[leader],
        a.e_k_ev[leader],
        a.ion[leader],
        relative,
    )
