"""What an element's lines would weigh at places where it has none: so much is chance.

Where peaks are crowded, an element of many lines finds peaks anywhere. Its lines are moved together by
several errors of the place, to either side, and weighed again by the same peaks: an element that is there
weighs far more at its own places (decoys, as proteomics has them: Elias and Gygi, Nature Methods 4, 207
(2007)).
"""

import numpy as np

from ..peaks.profiles import Profiles
from ..spectrum.spectrum import BoolArray, FloatArray
from .abundance_prior import log_odds
from .catalogue import Catalogue, Expected
from .evidence_score import evidence_score, take
from .index import ENOUGH, Indexed, weighed
from .match import Matched, match_lines
from .offsets import Offsets

MOVED = np.array(
    [-22.0, -17.0, -13.0, -9.5, -6.5, 6.5, 9.5, 13.0, 17.0, 22.0]
)  # errors of the place


def by_chance(
    known: Catalogue,
    expected: Expected,
    log_area: FloatArray,
    matched: Matched,
    indexed: Indexed,
    profiles: Profiles,
    bad: BoolArray,
    offsets: Offsets,
    stark_nm: FloatArray,
    unsure: FloatArray,
    model_spread: float,
) -> FloatArray:
    """The weight of each element at places that are not its own, shape (e,), at least 0.

    Of all places the second largest: one of them may fall on another element's lines. Accepted
    elements that are not everywhere are asked, and all where they explain little of the light, as on
    an axis that is wrong; the peaks have what the others leave.
    The arguments are those of `match_lines` and `index_peaks`, and their results.
    """
    found = np.zeros(len(known.first) - 1)
    doubtful = indexed.explained(profiles.peaks.area) < ENOUGH
    asked = [e for e in indexed.accepted if doubtful or log_odds()[e] < 0.0]
    if not asked:
        return found
    spans = [known.spans[e] for e in asked]
    entries = np.concatenate([np.tile(span, len(MOVED)) for span in spans])
    by = matched.place_error_nm * np.concatenate([np.repeat(MOVED, len(span)) for span in spans])
    moved = match_lines(
        profiles, profiles.wavelength_nm, bad, offsets, expected.vacuum_nm[entries] + by,
        matched.place_error_nm, stark_nm[entries],
    )  # fmt: skip
    lines, peaks = weighed(
        known.low_ev[entries], known.uncertainty[entries], log_area[entries], moved, model_spread,
        unsure[entries],
    )  # fmt: skip
    own, _ = weighed(known.low_ev, known.uncertainty, log_area, matched, model_spread, unsure)
    begin = 0
    for e, span in zip(asked, spans, strict=True):
        taken = np.zeros(len(matched.area))
        for other in indexed.accepted:
            if other != e:
                take(
                    known.first[other], known.first[other + 1], indexed.log_scale[other], own,
                    matched.area, taken,
                )  # fmt: skip
        free = np.log(np.maximum(matched.area - taken, 1e-6 * matched.area))
        weights = np.empty(len(MOVED))
        for n in range(len(MOVED)):
            weights[n], _ = evidence_score(begin, begin + len(span), lines, peaks, free)
            begin += len(span)
        found[e] = max(np.sort(weights)[-2], 0.0)
    return found
