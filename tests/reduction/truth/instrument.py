"""Detectors: segments with their own errors and widths, channels, noise, channels that are broken."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d, uniform_filter1d

from .light import STEP_NM


@dataclass(frozen=True)
class Instrument:
    """axis_nm: what the instrument says of its channels; edges_nm: where segments meet.

    offset_nm and fwhm_nm: of each segment. shown = true + offset. lorentzian: the part of the slit
    function that is Lorentzian. gain: counts an electron; averaged: how many shots the counts are
    the mean of.
    """

    axis_nm: np.ndarray
    edges_nm: np.ndarray
    offset_nm: np.ndarray
    fwhm_nm: np.ndarray
    medium: str
    lorentzian: float
    gain: float
    read_noise: float
    full_well: float
    averaged: int

    def segment(self, shown_nm: np.ndarray) -> np.ndarray:
        return np.searchsorted(self.edges_nm, shown_nm)

    def shown(self, vacuum_nm: np.ndarray) -> np.ndarray:
        """Where on the axis a vacuum wavelength is seen."""
        true = air_of(vacuum_nm) if self.medium == "air" else vacuum_nm
        return true + self.offset_nm[self.segment(true)]

    def looked_at(self) -> np.ndarray:
        """The vacuum wavelength that each channel really sees."""
        true = self.axis_nm - self.offset_nm[self.segment(self.axis_nm)]
        return vacuum_of(true) if self.medium == "air" else true


def air_of(vacuum_nm: np.ndarray) -> np.ndarray:
    """Birch and Downs's index of standard air (Metrologia 31, 315 (1994))."""
    s2 = (1000.0 / np.asarray(vacuum_nm, float)) ** 2
    return vacuum_nm / (1 + 8.34254e-5 + 2.406147e-2 / (130 - s2) + 1.5998e-4 / (38.9 - s2))


def vacuum_of(air_nm: np.ndarray) -> np.ndarray:
    vacuum = np.array(air_nm, float)
    for _ in range(4):
        vacuum = vacuum + (air_nm - air_of(vacuum))
    return vacuum


def draw_instrument(rng: np.random.Generator, held_out: bool) -> Instrument:
    """An instrument of the everyday kinds: 2,000 to 30,000 channels, 0.06 to 0.4 nm."""
    fwhm = float(np.exp(rng.uniform(np.log(0.06), np.log(0.4))))
    ranges = [(190, 961), (200, 900), (240, 850), (190, 620), (350, 800), (580, 900)]
    if held_out:
        ranges = [(190, 950), (220, 780), (260, 960), (195, 500), (380, 880), (190, 961)]
    first, last = ranges[rng.integers(len(ranges))]
    n_channels = int(np.clip((last - first) / (fwhm / rng.uniform(2.3, 6.0)), 2_000, 30_000))
    n_segments = int(rng.integers(1, 5))
    edges = np.sort(rng.uniform(first + 30, last - 30, n_segments - 1))
    edges = edges[np.diff(edges, prepend=first) > 50]
    n_segments = len(edges) + 1
    well_set = rng.random() < 0.4
    offset = rng.normal(0, 0.02, n_segments) if well_set else rng.uniform(-0.2, 0.2, n_segments)
    return Instrument(
        _axis(rng, first, last, n_channels, edges),
        edges,
        offset,
        fwhm * rng.uniform(0.8, 1.25, n_segments),
        "vacuum" if rng.random() < 0.3 else "air",
        rng.uniform(0.0, 0.15) if held_out else rng.choice([0.0, 0.05]),
        rng.uniform(0.1, 0.6),
        rng.uniform(2, 9),
        65_535.0,
        int(rng.choice([1, 1, 5])),
    )


def _axis(rng, first, last, n, edges):
    """Even channels (a resampled export), or each segment with its own pitch that drifts."""
    if rng.random() < 0.5 or not len(edges):
        return np.linspace(first, last, n)
    bounds = np.concatenate([[first], edges, [last]])
    parts = []
    for k in range(len(bounds) - 1):
        share = max(
            int(n * (bounds[k + 1] - bounds[k]) / (last - first) * rng.uniform(0.8, 1.2)), 20
        )
        t = (np.arange(share) + 0.5) / share
        bent = t + rng.uniform(-0.08, 0.08) * t * (1 - t)
        parts.append(bounds[k] + bent * (bounds[k + 1] - bounds[k]))
    return np.concatenate(parts)[:30_000]


def see(nm: np.ndarray, radiance: np.ndarray, instrument: Instrument) -> np.ndarray:
    """What each channel receives of the light on a fine grid: slit, then the channel's own width."""
    at = instrument.looked_at()
    segment = instrument.segment(instrument.axis_nm)
    pitch = np.gradient(instrument.axis_nm)
    seen = np.zeros(len(at))
    for k in range(len(instrument.fwhm_nm)):
        rows = np.flatnonzero(segment == k)
        if not len(rows):
            continue
        near = (nm > at[rows[0]] - 8) & (nm < at[rows[-1]] + 8)
        blurred = _blur(radiance[near], instrument.fwhm_nm[k], instrument.lorentzian)
        box = 2 * round(float(np.median(pitch[rows])) / STEP_NM / 2) + 1  # odd: it shifts nothing
        seen[rows] = np.interp(at[rows], nm[near], uniform_filter1d(blurred, box))
    return seen


def _blur(radiance, fwhm_nm, lorentzian):
    gauss = gaussian_filter1d(radiance, fwhm_nm / 2.3548 / STEP_NM, mode="nearest", truncate=5)
    if not lorentzian:
        return gauss
    half = fwhm_nm / 2 / STEP_NM
    away = np.arange(-int(40 * half), int(40 * half) + 1)
    foot = 1 / (1 + (away / half) ** 2)
    # It brings the whole of scipy's statistics: not for everyone who only collects the tests.
    from scipy.signal import fftconvolve

    return (1 - lorentzian) * gauss + lorentzian * fftconvolve(radiance, foot / foot.sum(), "same")


def record(light: np.ndarray, instrument: Instrument, rng: np.random.Generator):
    """Counts with noise, and the noise (standard deviation) that they were drawn with."""
    variance = instrument.gain * np.maximum(light, 0) + instrument.read_noise**2
    noise = np.sqrt(variance / instrument.averaged)
    counts = light + noise * rng.standard_normal(len(light))
    return np.minimum(counts, instrument.full_well), noise


def spoil(counts: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Kill and heat a few channels in place; True where a channel is bad."""
    bad = np.zeros(len(counts), bool)
    dead = rng.integers(0, len(counts), rng.integers(0, 8))
    hot = rng.integers(0, len(counts), rng.integers(0, 5))
    counts[dead] = rng.choice([0.0, np.nan])
    counts[hot] += rng.uniform(300, 8000, len(hot))
    bad[dead] = bad[hot] = True
    return bad
