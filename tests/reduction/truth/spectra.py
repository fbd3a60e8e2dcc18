"""One spectrum and all that is known of it; the same seed gives the same spectrum."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import find_peaks
from scipy.special import voigt_profile

from .instrument import Instrument, draw_instrument, record, see, spoil
from .light import Light, Zone, shine, widths
from .samples import FRESH, HELD_OUT, TRAIN, atom_shares

FAMILIES = {
    "train": (1_000, TRAIN),
    "held out": (900_000, HELD_OUT),
    "fresh": (1_700_000, FRESH),
    "unseen": (2_600_000, FRESH),  # seeds that no choice has been made with
}
SEEN_APART = 0.5  # lines nearer than this part of a seen width count as one


@dataclass(frozen=True)
class Groups:
    """Lines that the instrument cannot part, strongest first absorbed; arrays of one row a group.

    shown_nm: where on the instrument's axis. area: counts nm. height: counts at the middle by
    themselves. noise: of the channel there. light: all line light there, counts. alone: no other
    light within two widths that would move the area by more than 2 %.
    """

    shown_nm: np.ndarray
    area: np.ndarray
    height: np.ndarray
    noise: np.ndarray
    light: np.ndarray
    alone: np.ndarray
    element: np.ndarray
    share: np.ndarray  # of the area, that the named element has


@dataclass(frozen=True)
class Truth:
    """A spectrum as a file would hold it, and what it was made of."""

    name: str
    wavelength_nm: np.ndarray
    intensity: np.ndarray
    noise: np.ndarray
    continuum: np.ndarray
    bad: np.ndarray
    instrument: Instrument
    kelvin: float
    log10_ne: float
    groups: Groups
    maxima_nm: np.ndarray
    maxima_sigma: np.ndarray  # prominence in noise
    present: frozenset[str]
    doubtful: frozenset[str]
    h_alpha: bool
    shares: dict[str, float]  # of all atoms


def make_spectrum(family: str, number: int) -> Truth:
    """Spectrum `number` of a family, of which FAMILIES has the names."""
    first_seed, samples = FAMILIES[family]
    rng = np.random.default_rng(first_seed + number)
    sample = samples[number % len(samples)]
    held_out = family != "train"
    instrument = draw_instrument(rng, held_out)
    shares = atom_shares(sample, rng, str(rng.choice(["argon", "air", "helium", "none"])))
    zones = draw_zones(rng, held_out)
    off = rng if rng.random() < 0.5 else None
    thickest = float(np.exp(rng.uniform(np.log(0.2), np.log(30))))
    range_nm = float(instrument.axis_nm[0]), float(instrument.axis_nm[-1])
    light = shine(shares, zones, range_nm, thickest, 2e-5, off)
    return measured(sample, light, instrument, rng, zones)


def draw_zones(rng, held_out):
    """One zone, or a hot core and a cool shell."""
    kelvin, log_ne = rng.uniform(8_000, 14_000), rng.uniform(16.0, 17.5)
    core = Zone(kelvin, 10**log_ne, 1.0)
    if rng.random() < 0.5:
        return (core,)
    share = rng.uniform(0.05, 0.35 if held_out else 0.25)
    shell = Zone(kelvin * rng.uniform(0.65, 0.85), 10**log_ne * rng.uniform(0.2, 0.5), share)
    return Zone(kelvin, 10**log_ne, 1 - share), shell


def measured(sample, light, instrument, rng, zones, continuum=None, response=None) -> Truth:
    """What an instrument makes of light; continuum (counts) and response of each channel are
    drawn if None."""
    net = see(light.nm, light.radiance, instrument)
    response = _response(instrument.axis_nm, rng) if response is None else response
    net = net * response
    scale = float(np.exp(rng.uniform(np.log(4e3), np.log(6.5e4)))) / float(net.max())
    net = net * scale
    if continuum is None:
        continuum = continuum_shape(instrument.axis_nm, rng) * float(np.exp(rng.uniform(3, 8)))
    counts, noise = record(net + continuum, instrument, rng)
    bad = spoil(counts, rng)
    factor = scale * np.interp(light.lines.nm, instrument.looked_at(), response)
    groups, gleams = _groups(light, instrument, noise, net, factor)
    saturated = counts >= instrument.full_well
    maxima_nm, maxima_sigma = _maxima(instrument.axis_nm, net, noise, bad)
    present, doubtful = _elements(groups, gleams)
    h_alpha = groups_of(groups, "H", 656.3 if instrument.medium == "air" else 656.5)
    return Truth(
        sample, instrument.axis_nm, counts, noise, continuum, bad | saturated, instrument,
        zones[0].kelvin, float(np.log10(zones[0].electrons_cm3)), groups, maxima_nm, maxima_sigma,
        present, doubtful, h_alpha, light.shares,
    )  # fmt: skip


def groups_of(groups: Groups, element: str, near_nm: float) -> bool:
    """Whether an element has a group of at least ten times the noise near a wavelength."""
    own = (groups.element == element) & (np.abs(groups.shown_nm - near_nm) < 0.5)
    return bool(np.any(own & (groups.height > 10 * groups.noise)))


def _response(nm, rng):
    """What calibration left over: up to a tenth, smooth."""
    t = (nm - nm[0]) / (nm[-1] - nm[0])
    return 1 + rng.uniform(0, 0.1) * np.sin(2 * np.pi * (rng.uniform(0.3, 1.5) * t + rng.random()))


def continuum_shape(nm: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A smooth continuum of one of several shapes, about 1 high."""
    kind = rng.integers(4)
    t = (nm - 190) / 771
    if kind == 0:
        return np.full(len(nm), 1.0)
    if kind == 1:
        return np.exp(-(((nm - rng.uniform(300, 600)) / rng.uniform(90, 250)) ** 2)) + 0.1
    if kind == 2:
        steps = 1 + 0.2 * (nm > rng.uniform(300, 450)) - 0.3 * (nm > rng.uniform(550, 700))
        return steps * (1.2 - 0.6 * t)
    waves = sum(np.sin(2 * np.pi * (k * t + rng.random())) / k for k in (1, 2, 3))
    return 1.0 + 0.3 * waves


def _groups(light: Light, instrument: Instrument, noise, net, factor) -> tuple[Groups, set[str]]:
    """The groups, and the elements that have any line of 2 sigma, hidden or not."""
    lines = light.lines
    sigma, gamma = widths(lines, light.zones[0])
    shown = instrument.shown(lines.nm)
    slit = instrument.fwhm_nm[instrument.segment(shown)] / 2.3548
    pitch = np.interp(shown, instrument.axis_nm, np.gradient(instrument.axis_nm))
    sigma = np.sqrt(sigma**2 + slit**2 + pitch**2 / 12)
    per_area = voigt_profile(0.0, sigma, gamma)
    full = 1.0645 * 2 * 0.47 / per_area  # of a Gaussian as high
    seen = light.area * factor * per_area
    own_noise = np.interp(shown, instrument.axis_nm, noise)
    inside = (shown > instrument.axis_nm[2]) & (shown < instrument.axis_nm[-3])
    order = [k for k in np.argsort(-seen) if inside[k] and seen[k] > 0.5 * own_noise[k]]
    taken = np.zeros(len(seen), bool)
    rows = []
    for k in order:
        if taken[k]:
            continue
        near = np.arange(*np.searchsorted(lines.nm, [lines.nm[k] - SEEN_APART * full[k],
                                                     lines.nm[k] + SEEN_APART * full[k]]))  # fmt: skip
        near = near[~taken[near]]
        taken[near] = True
        rows.append(_group(k, near, light, lines, shown, full, seen, factor, per_area,
                           own_noise, instrument, net))  # fmt: skip
    columns = list(zip(*rows, strict=True)) if rows else [[] for _ in range(8)]
    gleams = set(lines.element[inside & (seen > 2 * own_noise)].tolist())
    return Groups(*(np.array(column) for column in columns)), gleams


def _group(k, near, light, lines, shown, full, seen, factor, per_area, noise, instrument, net):
    rough = light.area[near]
    exact = seen[k] > 5 * noise[k]
    total = light.group_area(near) if exact else float(rough.sum())
    weight = rough / rough.sum()
    centre = float(weight @ shown[near])
    height = total * factor[k] * float(weight @ per_area[near])
    others = np.abs(shown - shown[k]) < 2.5 * full[k]
    others[near] = False
    foreign = float(np.sum(light.area[others] * factor[others]))
    names, which = np.unique(lines.element[near], return_inverse=True)
    shares = np.bincount(which, weight)
    best = int(np.argmax(shares))
    edge = np.abs(instrument.edges_nm - shown[k]).min(initial=99.0) > 1.0
    alone = exact and edge and foreign < 0.02 * total * factor[k] and full[k] < 1.0
    at = float(np.interp(shown[k], instrument.axis_nm, net))
    alone = alone and at < 1.1 * height  # no far wing of something else below it
    return (centre, total * factor[k], height, noise[k], at, alone, str(names[best]), shares[best])


def _maxima(nm, net, noise, bad):
    peaks, found = find_peaks(net, prominence=0.5 * noise)
    inside = (peaks > 1) & (peaks < len(net) - 2)
    peaks, prominence = peaks[inside], found["prominences"][inside]
    good = ~(bad[peaks] | bad[peaks - 1] | bad[peaks + 1])
    peaks, prominence = peaks[good], prominence[good]
    left, top, right = net[peaks - 1], net[peaks], net[peaks + 1]
    shift = 0.5 * (left - right) / np.minimum(left - 2 * top + right, -1e-12)
    return nm[peaks] + shift * np.gradient(nm)[peaks], prominence / noise[peaks]


def _elements(groups: Groups, gleams: set[str]) -> tuple[frozenset[str], frozenset[str]]:
    """Present: two clean groups of 5 sigma, one of them of 10; or one of 30.

    Clean: the element has 70 % of the group, and the group half of the light in its middle. Of
    what shines less, but has a line above 2 sigma, neither a claim nor silence is wrong: doubtful.
    """
    sigma = groups.height / groups.noise
    clean = (groups.share > 0.7) & (groups.height > 0.5 * groups.light)
    present = set()
    for element in set(groups.element.tolist()):
        own = groups.element == element
        seen = np.sort(sigma[own & clean])[::-1]
        if len(seen) and (seen[0] > 30 or (len(seen) > 1 and seen[0] > 10 and seen[1] > 5)):
            present.add(element)
    return frozenset(present), frozenset(gleams - present)


def line_free(number: int, family: str = "train") -> tuple[np.ndarray, np.ndarray]:
    """Axis and counts of a continuum with noise and bad channels, but no line."""
    rng = np.random.default_rng(50_000 + FAMILIES[family][0] + number)
    instrument = draw_instrument(rng, family != "train")
    light = continuum_shape(instrument.axis_nm, rng) * float(np.exp(rng.uniform(3, 9)))
    counts, _ = record(light, instrument, rng)
    spoil(counts, rng)
    return instrument.axis_nm, counts


def pure_noise(number: int, family: str = "train") -> tuple[np.ndarray, np.ndarray]:
    """Axis and counts of nothing but read noise around zero."""
    rng = np.random.default_rng(70_000 + FAMILIES[family][0] + number)
    instrument = draw_instrument(rng, family != "train")
    noise = rng.normal(0, instrument.read_noise, len(instrument.axis_nm))
    return instrument.axis_nm, noise
