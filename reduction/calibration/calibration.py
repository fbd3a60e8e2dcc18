"""A calibration as a file keeps it, and what it says of a spectrum."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from ..elements.elements import DEFAULT_ELEMENTS, Line
from ..lines.formula import Closed
from ..reduce import Reduction
from ..spectrum.spectrum import FloatArray
from .curve import Curve
from .multivariate import Likeness, Pls, binned
from .signals import Signal, line_signal, total_light

MADE_BY = "labrun calibrate standards"
LIGHT = "total light"
AREA = "area"
WHOLE = "whole spectrum"
FROM_SEEN = 1.5  # total light beyond that of all standards by so much is worth a word


class CalibrationFault(ValueError):
    """A file that is no calibration; the text says why."""


@dataclass(frozen=True, slots=True)
class Point:
    """A standard on a curve: its known concentration, the mean of its shots' signals and their
    standard deviation (None of one), and what the curve through the others says of it."""

    sample: str
    wt_percent: float
    signal: float
    scatter: float | None
    shots: int
    cross_validated: float


@dataclass(frozen=True, slots=True)
class ElementCalibration:
    """by: what the area is divided by: AREA (nothing), LIGHT, or the line of `internal`; WHOLE where the
    signal is what `pls` reads, and there is no one line.

    lowest: of the standards above 0, wt %. rmsecv: wt %, leaving one standard out at a time. lod
    and loq: of one shot, wt %.
    """

    line: Line | None
    by: str
    internal: Line | None
    curve: Curve
    lowest: float
    lod: float
    loq: float
    rmsecv: float
    points: tuple[Point, ...]
    pls: Pls | None = None

    def signal(self, reduction: Reduction, range_nm: tuple[float, float]) -> Signal | None:
        """Of one shot; None where its spectrum does not tell it. range_nm: of the card."""
        if self.pls is not None:
            return Signal(float(self.pls.read(binned(reduction, range_nm))), 0.0)
        assert self.line is not None
        return signal_of(reduction, self.line, self.by, self.internal)


@dataclass(frozen=True, slots=True)
class Card:
    """By whom, on what and when; and for what it is valid."""

    by: str
    made: str
    labrun: str
    standards: str
    standards_sha256: str
    samples: int
    spectra: int
    note: str
    channels: int
    first_nm: float
    last_nm: float
    light: tuple[float, float]  # least and greatest total light of a shot, counts nm
    response_sha256: str | None


@dataclass(frozen=True, slots=True)
class Concentration:
    """What a calibration says of one element, wt %: with its standard error, and the ends of the
    95 % interval. None is unknown: below the limit of detection there is an upper end alone, where
    the curve ends a lower one. flags: sentences."""

    wt_percent: float | None
    error: float | None
    low: float | None
    high: float | None
    flags: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class OnePoint:
    """What standards tell of an element whose amount is read from the Saha-Boltzmann plot: `log_factor`
    is added to ln(amount), with its standard error for one shot; lost: e-folds of light that its lines lost
    to self-absorption in the standards; standards: how many told it, 0 where a file does not say."""

    log_factor: float
    error: float
    lost: float
    standards: int = 0


@dataclass(frozen=True, slots=True)
class Calibration:
    """Curves by element, or for a closure one point of each. likeness: of a spectrum to the standards',
    where it was modelled."""

    card: Card
    elements: dict[str, ElementCalibration]
    made_by: str = MADE_BY
    likeness: Likeness | None = None
    closed: Closed | None = None
    points: dict[str, OnePoint] = field(default_factory=dict)

    @property
    def range_nm(self) -> tuple[float, float]:
        """Of the axis."""
        return self.card.first_nm, self.card.last_nm

    def other_axis(self, wavelength_nm: FloatArray) -> str | None:
        """Why spectra on this axis are of another instrument; None if they are not."""
        own, n = self.card, len(wavelength_nm)
        first, last = float(wavelength_nm[0]), float(wavelength_nm[-1])
        near = (own.last_nm - own.first_nm) / max(own.channels - 1, 1)
        if n == own.channels and max(abs(first - own.first_nm), abs(last - own.last_nm)) < near:
            return None
        return (
            f"{n:,} channels from {first:.3f} to {last:.3f} nm, where the calibration has "
            f"{own.channels:,} from {own.first_nm:.3f} to {own.last_nm:.3f} nm"
        )

    def other_response(self, used: str | None, name: str) -> str | None:
        """How it was made, where the response that is used is another one; None if it is not. used: its
        sha256, None without one. name: what it is called where it is given."""
        made_with = self.card.response_sha256
        if made_with == used:
            return None
        if made_with is None:
            return f"without a {name}: leave `{name}` out, or make one with `--response`"
        return f"with {'another' if used else 'a'} {name}: give that file as `{name}`"

    def notes(self, wavelength_nm: FloatArray, reduction: Reduction) -> tuple[str, ...]:
        """Sentences on how a spectrum lies outside the calibration."""
        axis = self.other_axis(wavelength_nm)
        if axis is not None:
            return (f"no concentrations, as this is another instrument's spectrum: {axis}",)
        said = []
        light, (least, most) = total_light(reduction), self.card.light
        if not least / FROM_SEEN <= light <= most * FROM_SEEN:
            said.append(
                "the total light is outside that of the calibration's standards "
                f"({least:.3g} to {most:.3g} counts nm); concentrations may be off"
            )
        if self.likeness is not None:
            said.append(self.likeness.outside(binned(reduction, self.range_nm)))
        return tuple(filter(None, said))

    def concentrations(
        self, wavelength_nm: FloatArray, shots: Sequence[Reduction]
    ) -> dict[str, Concentration]:
        """By element, of the shots at one place; empty for another instrument.

        Each shot is measured by itself, as those of the standards were: in the mean of several a
        blend may be parted that is one peak in each.
        """
        if self.other_axis(wavelength_nm) is not None:
            return {}
        return {name: _told(one, shots, self.range_nm) for name, one in self.elements.items()}


def asked_for(calibrated: Iterable[str], elements: Sequence[str] | None) -> tuple[str, ...]:
    """The elements whose lines are sought with the greater care: the same for standards and unknowns."""
    return tuple(dict.fromkeys([*(elements or DEFAULT_ELEMENTS), *calibrated]))


def signal_of(reduction: Reduction, line: Line, by: str, internal: Line | None) -> Signal | None:
    """The signal that a curve is made of; None where the spectrum does not tell it."""
    found = line_signal(reduction, line)
    if found is None or by == AREA:
        return found
    if internal is None:
        over = total_light(reduction)
    else:
        other = line_signal(reduction, internal)
        if other is None or other.area < 3 * other.noise:
            return None
        over = other.area
    return Signal(found.area / over, found.noise / over) if over > 0 else None


def _told(
    one: ElementCalibration, each: Sequence[Reduction], range_nm: tuple[float, float]
) -> Concentration:
    told = [one.signal(shot, range_nm) for shot in each]
    found = [signal for signal in told if signal is not None]
    if not found:
        which = "its line" if one.internal is None else f"its line or {one.internal.element}'s"
        why = f"not measured: {which} is out of range, full, or on bad channels"
        return Concentration(None, None, None, None, (why,))
    shots, curve = len(found), one.curve
    area = float(np.mean([signal.area for signal in found]))
    noise = float(np.sqrt(np.mean([signal.noise**2 for signal in found])))
    estimate = curve.read(area, shots, noise)
    high = None if np.isinf(estimate.high) else estimate.high
    if estimate.wt_percent < curve.lod(shots, noise):
        return Concentration(None, None, None, high, ("below LOD",))
    above = f"above range: the standards end at {curve.highest:.4g} wt %"
    if estimate.wt_percent >= 0.999 * curve.top:
        return Concentration(None, None, estimate.low, None, (above,))
    flags = ["below LOQ"] if estimate.wt_percent < curve.loq(shots, noise) else []
    beyond = estimate.wt_percent - estimate.error > curve.highest
    flags += [above] if beyond else []
    return Concentration(estimate.wt_percent, estimate.error, estimate.low, high, tuple(flags))


def to_text(calibration: Calibration) -> str:
    """The file, as JSON."""
    from pydantic import TypeAdapter

    return TypeAdapter(Calibration).dump_json(calibration, indent=1).decode() + "\n"


@lru_cache(maxsize=4)
def read_calibration(text: str) -> Calibration:
    """The calibration in a file's text. Raises CalibrationFault."""
    from pydantic import TypeAdapter, ValidationError

    try:
        found = TypeAdapter(Calibration).validate_json(text)
    except ValidationError as fault:
        first = fault.errors()[0]
        place = "".join(f"{part}: " for part in first["loc"])
        raise CalibrationFault(
            f"no calibration as `{MADE_BY}` writes it: {place}{first['msg']}"
        ) from None
    if found.made_by != MADE_BY or not (found.elements or (found.closed and found.points)):
        raise CalibrationFault(f"no calibration as `{MADE_BY}` writes it")
    return found
