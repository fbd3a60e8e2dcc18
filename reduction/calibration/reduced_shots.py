"""Reduce the shots at one place with a calibration: peaks and plasma of their mean, and wt %."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ..lines.formula import Closed
from ..reduce import Reduction, reduce_spectrum
from ..spectrum.shots import Shots
from ..spectrum.spectrum import Medium, Spectrum
from .calibration import Calibration, Concentration, asked_for
from .closure import concentrations

NOT_CALIBRATED = Concentration(None, None, None, None, ("not calibrated",))


@dataclass(frozen=True, slots=True)
class ReducedShots:
    """contents: by element, empty for another instrument. doubts: sentences on how the spectrum lies
    outside the calibration."""

    reduction: Reduction
    contents: dict[str, Concentration]
    doubts: tuple[str, ...]

    def to_dict(self, elements: Sequence[str] | None = None) -> dict[str, Any]:
        """As plain values, with the names of the contract `spectrum_reducer@1`. elements: whose areas
        are wanted; they have a concentration, too, if an unknown one."""
        found = self.reduction.to_dict()
        shown = found["areas"] if elements is None else elements
        contents = dict.fromkeys(elements or (), NOT_CALIBRATED) | self.contents
        return {
            **found,
            "areas": {name: found["areas"][name] for name in shown},
            "offsets": {name: found["offsets"][name] for name in shown},
            "wt_percent": {name: one.wt_percent for name, one in contents.items()},
            "wt_percent_err": {name: one.error for name, one in contents.items()},
            "wt_percent_low": {name: one.low for name, one in contents.items()},
            "wt_percent_high": {name: one.high for name, one in contents.items()},
            "wt_percent_flags": {name: "; ".join(one.flags) for name, one in contents.items()},
            "doubts": "; ".join(self.doubts),
        }


def reduce_shots(
    shots: Shots,
    known: Calibration | Closed,
    elements: Sequence[str] | None = None,
    medium: Medium | None = None,
    seen: Callable[[Spectrum], Spectrum] = lambda one: one,
) -> ReducedShots:
    """known: a calibration, or what a closure without one closes. elements, medium: as for
    `reduce_spectrum`; seen: divides the instrument's response out."""
    spectrum = seen(shots.mean())
    x = spectrum.wavelength_nm
    if not isinstance(known, Calibration):
        reduction = reduce_spectrum(spectrum, elements, medium)
        return ReducedShots(reduction, concentrations(reduction, known), ())
    asked = asked_for(known.elements, elements)
    reduction = reduce_spectrum(spectrum, asked, medium)
    if known.closed is not None:
        told = {}
        if known.other_axis(x) is None:
            told = concentrations(reduction, known.closed, known.points)
        return ReducedShots(reduction, told, known.notes(x, reduction))
    each = [reduction]
    if len(shots) > 1:
        each = [reduce_spectrum(seen(one), asked, medium) for one in shots.each()]
    return ReducedShots(reduction, known.concentrations(x, each), known.notes(x, reduction))
