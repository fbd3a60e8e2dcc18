"""The rows of `elements`: the evidence for each element, and the strength of its line.

Requested elements and the usual elements of rocks have their predominant line, the same in every
spectrum, so that their areas can be mapped; the others have their strongest matched line.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..elements.elements import ElementPeak, find_elements, with_hydrogen
from ..elements.evidence import Evidence
from ..elements.match import LIMIT_SIGMA
from ..elements.offsets import Offsets
from ..lines.air import in_medium
from ..lines.lines import of_lines
from ..lines.usual import USUAL_LINES
from ..peaks.voigt import SIGMA_PER_FWHM
from ..plasma.strengths import atoms
from ..reduce import Reduction
from ..spectrum.spectrum import FloatArray
from .columns import BETWEEN_FLAGS, Cells

if TYPE_CHECKING:
    from ..calibration.calibration import Concentration

BOX_OF_GAUSSIAN = 1.0645  # area / (height * fwhm)
BETWEEN_ELEMENTS = " "
SAME_ENTRY_NM = 0.1  # between a predominant line and the catalogue's entry for it
NEVER_WEIGHED = -1e6  # lower scores are of elements without evidence to weigh
NAN = float("nan")
NOTHING = Evidence("", "absent", NAN, 0, 0, NAN, NAN, NAN, (), NAN)


def element_rows(
    wavelength_nm: FloatArray,
    reduction: Reduction,
    only: Sequence[str] | None = None,
    contents: Mapping[str, Concentration] | None = None,
) -> Cells:
    """A row for each element of `only`, in that order; else for all with lines in the spectrum.

    wavelength_nm: of the spectrum, shape (m,). contents: what a calibration says, by element.
    """
    usual = _usual(wavelength_nm, reduction, reduction.offsets)
    contents = contents or {}
    seen = {*reduction.evidence, *reduction.elements, *contents}
    wanted = sorted(seen) if only is None else list(only)
    said = [reduction.evidence.get(name, NOTHING) for name in wanted]
    area = np.array([e.area for e in said])
    shown_nm = np.array([e.line_nm for e in said])
    limit = np.array([e.detection_limit for e in said])
    score = np.array([e.score for e in said])
    vacuum_nm = _tabulated(shown_nm, reduction)
    for row, name in enumerate(wanted):
        peak = usual.get(name)
        if peak is not None and peak.fate != "outside the spectrum":
            area[row], vacuum_nm[row] = peak.area, peak.line.wavelength_nm
            limit[row] = _limit(name, peak.line.wavelength_nm, reduction)
    return {
        "element": wanted,
        "status": [e.status for e in said],
        "score": np.where(score < NEVER_WEIGHED, np.nan, score),
        "lines_matched": [e.lines_matched for e in said],
        "lines_expected": [e.lines_expected for e in said],
        "area": area,
        "line_nm": in_medium(vacuum_nm, reduction.medium),
        "confounders": [BETWEEN_ELEMENTS.join(e.confounders) for e in said],
        "detection_limit": limit,
        **_contents([contents.get(name) for name in wanted]),
    }


def _contents(told: Sequence[Concentration | None]) -> Cells:
    return {
        "wt_percent": [None if one is None else one.wt_percent for one in told],
        "wt_percent_err": [None if one is None else one.error for one in told],
        "wt_percent_low": [None if one is None else one.low for one in told],
        "wt_percent_high": [None if one is None else one.high for one in told],
        "wt_percent_flags": ["" if one is None else BETWEEN_FLAGS.join(one.flags) for one in told],
    }


def _usual(x: FloatArray, reduction: Reduction, offsets: Offsets) -> dict[str, ElementPeak]:
    """The predominant peaks of the requested and the usual elements."""
    more = [name for name in USUAL_LINES if name not in reduction.elements]
    range_nm = (float(x[0]), float(x[-1]))
    others = find_elements(reduction.peaks, more, range_nm, offsets)
    broad = None if reduction.identified is None else reduction.identified.hydrogen
    return {**reduction.elements, **with_hydrogen(others, broad, offsets)}


def _tabulated(shown_nm: FloatArray, reduction: Reduction) -> FloatArray:
    """Vacuum wavelengths of lines given as the instrument shows them, same shape."""
    found = reduction.identified
    if found is None:
        return np.full(len(shown_nm), np.nan)
    nearly = found.catalogue.order  # of wavelengths at another temperature
    order = nearly[np.argsort(found.matched.shown_nm[nearly], kind="stable")]
    at = np.searchsorted(found.matched.shown_nm[order], shown_nm).clip(0, len(order) - 1)
    return np.where(np.isnan(shown_nm), np.nan, found.expected.vacuum_nm[order[at]])


@of_lines()
def _places() -> dict[str, int]:
    """Which of the elements each symbol is."""
    return {name: e for e, name in enumerate(atoms().elements.tolist())}


def _limit(name: str, vacuum_nm: float, reduction: Reduction) -> float:
    """Area at which the line would show at three times the noise, counts nm."""
    found = reduction.identified
    if found is not None:
        entries = found.catalogue.spans[_places()[name]]
        away = np.abs(found.expected.vacuum_nm[entries] - vacuum_nm)
        nearest = int(away.argmin()) if len(away) else 0
        if len(away) and away[nearest] < SAME_ENTRY_NM:
            return float(found.matched.limit[entries[nearest]])
    profiles = reduction.profiles
    x = profiles.wavelength_nm
    place = reduction.offsets.shown(np.array([vacuum_nm]))[0]
    at = int(np.searchsorted(x, place).clip(1, len(x) - 1))
    fwhm = max(profiles.slit.sigma_nm[at] / SIGMA_PER_FWHM, 1.5 * (x[at] - x[at - 1]))
    return float(LIMIT_SIGMA * profiles.noise[at] * BOX_OF_GAUSSIAN * fwhm)
