"""Concentrations corrected for a drift of the instrument that its check standards show.

A reading falls or rises along a straight line in the order of the points. Each point is brought to where
the standard read at the first check; that the standard was read right there is judged elsewhere (checks).
The factor is that of the signal, and of the concentration as far as the curve is straight and goes
through 0.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..spectrum.spectrum import FloatArray
from .checks import Checks
from .points.contents import Contents

CORRECTED = "drift corrected"
NORMAL_95 = 1.96
LEAST_LEFT = 0.2  # of the first reading: what is left of less says nothing


@dataclass(frozen=True, slots=True)
class Drift:
    """A straight line through readings: `slope` for each point as a part of the reading at the first
    check, with its standard error, from the point `first` to `last`."""

    first: float
    last: float
    slope: float
    error: float

    def factor(self, place: FloatArray) -> tuple[FloatArray, FloatArray]:
        """What concentrations are multiplied by, and its standard error, at points; any shape. Beyond the
        checks as at the nearest one."""
        away = np.clip(place, self.first, self.last) - self.first
        left = np.maximum(1 + self.slope * away, LEAST_LEFT)
        return 1 / left, self.error * away / left**2


def drift_of(checks: Checks) -> Drift | None:
    """None where nothing drifts for sure, or checks do not tell between which points they were."""
    known = np.isfinite(checks.found) & np.isfinite(checks.place)
    if not checks.drifts or known.sum() < len(checks.values) or np.ptp(checks.place[known]) == 0:
        return None
    place, found = checks.place[known], checks.found[known]
    first = float(place.min())
    slope, start = np.polyfit(place - first, found, 1)
    left = found - (slope * (place - first) + start)
    spread = np.sum((place - place.mean()) ** 2)
    error = float(np.sqrt(left @ left / (len(found) - 2) / spread))
    return Drift(first, float(place.max()), float(slope / start), error / float(start))


def corrected(
    contents: dict[str, Contents], place: FloatArray, checks: Sequence[Checks]
) -> tuple[dict[str, Contents], list[str]]:
    """The contents of points (n,) by element, and sentences on what was corrected and what was not.

    place: how many points were before each, as the checks count them. Of several standards of an
    element the one with the most readings counts.
    """
    said, found = [], dict(contents)
    for element in contents:
        own = [one for one in checks if one.element == element]
        if not own:
            said.append(f"{element}: not corrected for drift, no check standard has it")
            continue
        check = max(own, key=lambda one: len(one.values))
        drift = drift_of(check)
        if drift is None:
            why = "no drift is seen"
            if check.drifts:
                why = "its rows have no column `point`, how many points were measured before"
            said.append(f"{element}: not corrected for drift, {why} ({check.standard})")
            continue
        factor, error = drift.factor(place)
        found[element] = _times(contents[element], factor, error)
        end, end_error = drift.factor(np.array(drift.last))
        said.append(
            f"{element}: corrected for drift by {check.standard} ({len(check.values)} checks): times 1 at "
            f"the first, {end:.3g} ± {end_error:.1g} at the last"
        )
    return found, said


def _times(one: Contents, factor: FloatArray, error: FloatArray) -> Contents:
    value, wide = one.value * factor, NORMAL_95 * error / factor
    flags = [
        "; ".join(filter(None, (str(flag), CORRECTED))) if known else flag
        for flag, known in zip(one.flags, one.known, strict=True)
    ]
    return Contents(
        value, np.hypot(one.error * factor, one.value * error), one.low * factor * np.maximum(1 - wide, 0),
        one.high * factor * (1 + wide), np.array(flags, dtype=object),
    )  # fmt: skip
