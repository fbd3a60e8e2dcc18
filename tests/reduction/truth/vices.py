"""What real instruments, exports and plasmas do that calibrated ones do not; one vice at a time."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from .everyday import SAMPLES
from .instrument import Instrument
from .light import Zone, shine
from .samples import atom_shares
from .spectra import Truth, draw_zones, measured

EDGES_NM = np.array([350.0, 620.0])
SPIKES = 60


@dataclass(frozen=True)
class Vice:
    """steps: gain of each detector. rolled, blazed: e-folds lost at the ends of the range; depth of
    an echelle's orders. bent_nm: of the axis, half a wave. thickest: optical depth of the thickest
    line; shell: part of the atoms in a cool layer outside. continuum: counts. well: counts at which
    a channel is full. photon: counts of one, behind an intensifier. Of the export: cut (at zero),
    digits of the counts, smoothed (channels)."""

    channels: int = 8_192
    fwhm_nm: float = 0.2
    steps: tuple[float, float, float] = (1.0, 1.0, 1.0)
    rolled: float = 0.0
    blazed: float = 0.0
    bent_nm: float = 0.0
    jumps_nm: float = 0.02
    thickest: float | None = None
    shell: float = 0.0
    continuum: float = 200.0
    well: float = 65_535.0
    spikes: int = 0
    photon: float = 0.0
    cut: bool = False
    digits: int | None = None
    smoothed: int = 1
    read_noise: float = 5.0


VICES = {
    "none": Vice(),
    "gain steps": Vice(steps=(1.0, 3.9, 1.6)),
    "steps of 20": Vice(steps=(1.0, 20.0, 8.0)),
    "roll-off": Vice(rolled=5.0),
    "blaze": Vice(blazed=0.75),
    "bent axis": Vice(bent_nm=0.18, jumps_nm=0.0),
    "thick": Vice(thickest=150.0),
    "reversed": Vice(thickest=60.0, shell=0.3),
    "continuum": Vice(continuum=20_000.0),
    "saturated": Vice(well=6_000.0),
    "spikes": Vice(spikes=SPIKES),
    "cut at zero": Vice(cut=True),
    "rounded": Vice(digits=-1),
    "smoothed": Vice(smoothed=3),
    "1 nm": Vice(channels=2_048, fwhm_nm=1.0),
    "handheld": Vice(steps=(1.0, 8.0, 4.0), rolled=4.0, bent_nm=0.15, thickest=20.0, shell=0.1,
                     cut=True),
    "photons": Vice(channels=32_768, fwhm_nm=0.09, photon=300.0, continuum=60.0),
}  # fmt: skip


def with_vice(name: str, number: int, samples: tuple[str, ...] = SAMPLES) -> Truth:
    """Spectrum `number` with a vice, of which VICES has the names, of one of the samples."""
    v = VICES[name]
    rng = np.random.default_rng(5_300_000 + 1_000 * list(VICES).index(name) + number)
    sample = samples[number % len(samples)]
    shares = atom_shares(sample, rng, "argon" if number % 2 else "air")
    core = draw_zones(rng, held_out=False)[0]
    zones = (core,) if not v.shell else (
        replace(core, share=1 - v.shell),
        Zone(0.6 * core.kelvin, 0.15 * core.electrons_cm3, v.shell),
    )  # fmt: skip
    thickest = v.thickest or float(np.exp(rng.uniform(-1.5, 1.5)))
    axis = np.linspace(190.0, 961.0, v.channels)
    light = shine(shares, zones, (190.0, 961.0), thickest, 2e-5, None)
    offset = rng.uniform(-v.jumps_nm, v.jumps_nm, len(EDGES_NM) + 1)
    fwhm = np.full(len(EDGES_NM) + 1, v.fwhm_nm)
    instrument = Instrument(axis, EDGES_NM, offset, fwhm, "air", 0.0, 0.3, v.read_noise, v.well, 1)
    response = _response(v, axis)
    under = v.continuum * response / np.max(response)
    truth = measured(sample, light, instrument, rng, zones, under, response)
    return _exported(_bent(truth, v.bent_nm), v, rng)


def _response(v: Vice, nm: np.ndarray) -> np.ndarray:
    gain = np.array(v.steps)[np.searchsorted(EDGES_NM, nm)]
    t = (nm - nm[0]) / (nm[-1] - nm[0])
    ends = np.clip(1 - t / 0.15, 0, 1) ** 2 + 0.5 * np.clip((t - 0.75) / 0.25, 0, 1) ** 2
    order = 1 - v.blazed * np.cos(np.pi * (nm / 12.0)) ** 2
    return gain * order * np.exp(-v.rolled * ends)


def _bent(truth: Truth, bent_nm: float) -> Truth:
    """The same light on an axis that says something else, smoothly: most at the short end."""
    if not bent_nm:
        return truth

    def shift(nm):
        return bent_nm * np.cos(0.5 * np.pi * (nm - 190.0) / 771.0)

    g = truth.groups
    axis = truth.wavelength_nm + shift(truth.wavelength_nm)
    groups = replace(g, shown_nm=g.shown_nm + shift(g.shown_nm))
    return replace(truth, wavelength_nm=axis, groups=groups,
                   maxima_nm=truth.maxima_nm + shift(truth.maxima_nm))  # fmt: skip


def _exported(truth: Truth, v: Vice, rng: np.random.Generator) -> Truth:
    counts, bad = truth.intensity.copy(), truth.bad.copy()
    for at in rng.integers(5, len(counts) - 5, v.spikes):
        counts[at : at + 2] += rng.uniform(300, 8_000)
        bad[at : at + 2] = True
    if v.photon:
        # A photon's electron is multiplied by an exponential law, and seen by neighbours, too.
        n = rng.poisson(np.maximum(np.nan_to_num(counts), 0.0) / v.photon)
        seen = np.where(n > 0, rng.gamma(np.maximum(n, 1), v.photon), 0.0)
        counts = np.convolve(seen, [0.15, 0.7, 0.15], "same") + rng.normal(0, v.read_noise, len(n))
    if v.smoothed > 1:
        counts = uniform_filter1d(np.nan_to_num(counts, nan=v.continuum), v.smoothed)
    if v.cut:
        # What exports do: a baseline that is a little too high, and nothing below zero.
        counts = np.maximum(counts - truth.continuum - 0.3 * truth.noise, 0.0)
    if v.digits is not None:
        counts = np.round(counts, v.digits)
    return replace(truth, intensity=counts, bad=bad)
