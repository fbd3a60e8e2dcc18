"""Instruments that people have: each kind is one trouble by itself, on several minerals.

The families of `spectra` mix all troubles; here one can see which of them breaks what.
"""

from dataclasses import dataclass, replace

import numpy as np

from .instrument import Instrument
from .light import shine
from .samples import atom_shares
from .spectra import Truth, draw_zones, measured

SAMPLES = ("spodumene", "muscovite", "K-feldspar", "limestone", "brine residue", "basalt glass")


@dataclass(frozen=True)
class Kind:
    """What is unusual about an instrument; the rest is an analyser of 22,800 channels."""

    range_nm: tuple[float, float] = (190.0, 961.0)
    channels: int = 22_800
    fwhm_nm: float = 0.12
    offset_nm: float = 0.02  # each of three segments is off by up to so much
    medium: str = "air"
    gain: float = 0.3
    read_noise: float = 5.0
    continuum: float = 200.0  # counts
    bent: float = 0.0  # of the continuum: e-folds along the axis
    resampled: int = 0  # channels that the detectors have, where the export has others
    scaled: float = 1.0  # what the counts are multiplied by in the end
    shifted: float = 0.0  # and what is added
    digits: int | None = None  # of the wavelengths in the export


KINDS = {
    "usual": Kind(),
    "0.2 nm off": Kind(offset_nm=0.2),
    "vacuum": Kind(medium="vacuum"),
    "vacuum, off": Kind(medium="vacuum", offset_nm=0.15),
    "0.06 nm sharp": Kind(channels=30_000, fwhm_nm=0.06),
    "0.4 nm coarse": Kind(channels=6_144, fwhm_nm=0.4),
    "0.4 nm, 22,800": Kind(fwhm_nm=0.4),
    "2,048 channels": Kind((300.0, 600.0), 2_048, 0.35),
    "500-700 nm": Kind((500.0, 700.0), 2_048, 0.2),
    "500-700 nm, 22,800": Kind((500.0, 700.0), 22_800, 0.2),
    "0 to 1": Kind(scaled=1 / 65_535.0),
    "below zero": Kind(shifted=-400.0),
    "heavy noise": Kind(gain=3.0, read_noise=80.0),
    "steep": Kind(continuum=8_000.0, bent=4.0),
    "resampled": Kind(resampled=8_192),
    "two digits": Kind(digits=2),
}


def everyday(kind: str, number: int) -> Truth:
    """Spectrum `number` of an everyday kind of instrument, of which KINDS has the names."""
    k = KINDS[kind]
    rng = np.random.default_rng(4_200_000 + 1_000 * list(KINDS).index(kind) + number)
    sample = SAMPLES[number % len(SAMPLES)]
    shares = atom_shares(sample, rng, "argon" if number % 2 else "air")
    zones = draw_zones(rng, held_out=False)
    light = shine(shares, zones, k.range_nm, float(np.exp(rng.uniform(-1.5, 2.5))), 2e-5, None)
    instrument = _instrument(k, rng)
    slope = np.exp(k.bent * (0.5 - np.linspace(0, 1, len(instrument.axis_nm))))
    truth = measured(sample, light, instrument, rng, zones, k.continuum * slope)
    return _exported(truth, k)


def _instrument(k: Kind, rng: np.random.Generator) -> Instrument:
    first, last = k.range_nm
    edges = np.array([350.0, 620.0]) if last - first > 500 else np.empty(0)
    offset = rng.uniform(-k.offset_nm, k.offset_nm, len(edges) + 1)
    axis = np.linspace(first, last, k.resampled or k.channels)
    fwhm = np.full(len(edges) + 1, k.fwhm_nm)
    return Instrument(
        axis, edges, offset, fwhm, k.medium, 0.0, k.gain, k.read_noise, 65_535.0, averaged=1
    )


def _exported(truth: Truth, k: Kind) -> Truth:
    """What the file says of what the detectors saw."""
    counts = truth.intensity * k.scaled + k.shifted
    x, noise, bad = truth.wavelength_nm, truth.noise * k.scaled, truth.bad
    if k.resampled:
        fine = np.linspace(x[0], x[-1], k.channels)
        counts, noise = np.interp(fine, x, counts), np.interp(fine, x, noise)
        x, bad = fine, np.interp(fine, x, bad.astype(float)) > 0
    if k.digits is not None:
        x = np.round(x, k.digits)
    g = truth.groups
    groups = replace(g, area=g.area * k.scaled, height=g.height * k.scaled,
                     noise=g.noise * k.scaled, light=g.light * k.scaled)  # fmt: skip
    return replace(truth, wavelength_nm=x, intensity=counts, noise=noise, bad=bad, groups=groups)
