"""The light of one or two zones in local equilibrium, by transfer through both on a fine grid.

Every line's opacity is added up first, so that lines which overlap absorb each other's light, as
they do in nature; the zones shine as Planck says where they are thick.
"""

from dataclasses import dataclass

import numpy as np
from scipy import constants as si
from scipy.special import voigt_profile

from .atoms import EV_K, Lines, ions_per_atom, lines_of, partition
from .samples import WEIGHT

STEP_NM = 0.004
H_ALPHA_NM = {656.46: (1.098, 0.67965), 486.27: (4.800, 0.68116), 434.17: (4.0, 0.68),
              410.29: (6.0, 0.68)}  # fmt: skip
NARROWEST_NM = 0.012


@dataclass(frozen=True)
class Zone:
    """One layer: kelvin, electrons per cm3, and its share of the atoms in sight."""

    kelvin: float
    electrons_cm3: float
    share: float


def planck(nm: np.ndarray, kelvin: float) -> np.ndarray:
    """Radiance of a black body per nm, in units of one at 500 nm and 10,000 K."""

    def shape(at, t):
        return at**-5.0 / np.expm1(si.h * si.c / (at * 1e-9 * si.k * t))

    return shape(nm, kelvin) / shape(500.0, 10_000.0)


def opacity(lines: Lines, shares: dict[str, float], zone: Zone) -> np.ndarray:
    """Each line's optical depth times nm, for one atom in sight (arbitrary unit)."""
    values = np.zeros(len(lines.nm))
    for element in shares:
        ratio = ions_per_atom(element, zone.kelvin, zone.electrons_cm3)
        for stage in (1, 2):
            rows = (lines.element == element) & (lines.stage == stage)
            share = shares[element] * (ratio if stage == 2 else 1.0) / (1.0 + ratio)
            low = np.exp(-lines.low_ev[rows] * EV_K / zone.kelvin)
            stimulated = -np.expm1(-(lines.high_ev - lines.low_ev)[rows] * EV_K / zone.kelvin)
            held = share / partition(element, stage, zone.kelvin) * low * stimulated
            # lambda^4 g_k A / 8 pi c; the constant is absorbed by the column chosen later
            values[rows] = zone.share * held * lines.ga[rows] * (lines.nm[rows] / 500) ** 4
    return values


def widths(lines: Lines, zone: Zone) -> tuple[np.ndarray, np.ndarray]:
    """Doppler sigma and Stark half width at half maximum, nm."""
    mass = np.array([WEIGHT[element] for element in lines.element]) * si.atomic_mass
    sigma = lines.nm * np.sqrt(si.k * zone.kelvin / mass) / si.c
    full = lines.stark_nm * zone.electrons_cm3 / 1e17
    for centre, (at_1e17, power) in H_ALPHA_NM.items():
        own = (lines.element == "H") & (np.abs(lines.nm - centre) < 0.2)
        full = np.where(own, at_1e17 * (zone.electrons_cm3 / 1e17) ** power, full)
    return sigma, np.maximum(full, NARROWEST_NM) / 2


@dataclass(frozen=True)
class Light:
    """A fine grid (vacuum nm), the light on it, and each line with its own light (area)."""

    nm: np.ndarray
    radiance: np.ndarray
    lines: Lines
    area: np.ndarray
    depth: np.ndarray
    zones: tuple[Zone, ...]
    column: float
    per_zone: tuple[np.ndarray, ...]
    shares: dict[str, float]

    def group_area(self, rows: np.ndarray) -> float:
        """What these lines would shine together without the others, radiance nm."""
        near = self.lines.where(rows)
        middle = float(np.mean(near.nm))
        far = 200 * float(max(widths(near, self.zones[0])[1]))
        reach = float(np.clip(far, 1.0, 40.0) + np.ptp(near.nm))
        x = np.arange(middle - reach, middle + reach, STEP_NM)
        return float(np.sum(_transfer(x, near, [d[rows] for d in self.per_zone],
                                      self.zones, reach)) * STEP_NM)  # fmt: skip


def _depths(x, lines, depth, zone, reach):
    """Optical depth along a grid of even steps."""
    tau = np.zeros(len(x))
    sigma, gamma = widths(lines, zone)
    for k in range(len(lines.nm)):
        far = min(max(0.4, 200 * gamma[k]), reach)
        first = max(int((lines.nm[k] - far - x[0]) / STEP_NM), 0)
        last = min(int((lines.nm[k] + far - x[0]) / STEP_NM) + 1, len(x))
        if last > first:
            tau[first:last] += depth[k] * voigt_profile(
                x[first:last] - lines.nm[k], sigma[k], gamma[k]
            )
    return tau


def _transfer(x, lines, depths, zones, reach):
    """From the core outwards: each zone lets through what it does not absorb, and adds its own."""
    radiance = np.zeros(len(x))
    for depth, zone in zip(depths, zones, strict=True):
        passed = np.exp(-_depths(x, lines, depth, zone, reach))
        radiance = radiance * passed + planck(x, zone.kelvin) * (1 - passed)
    return radiance


def shine(
    shares: dict[str, float], zones: tuple[Zone, ...], range_nm: tuple[float, float],
    thickest: float, faintest: float, off: np.random.Generator | None,
) -> Light:  # fmt: skip
    """The light of a plasma whose thickest line has the optical depth `thickest`.

    faintest: how weak a line may be, as a part of the strongest, and still be drawn. off: draws
    the errors of the transition probabilities within their accuracy class (None: they are right).
    """
    lines = lines_of(tuple(sorted(e for e, s in shares.items() if s > 0)))
    lines = lines.where((lines.nm > range_nm[0] - 1) & (lines.nm < range_nm[1] + 1))
    per_zone = [opacity(lines, shares, zone) for zone in zones]
    if off is not None:
        wrong = np.exp(0.5 * lines.uncertain * off.standard_normal(len(lines.nm)))
        per_zone = [depth * wrong for depth in per_zone]
    sigma, gamma = widths(lines, zones[0])
    peak = per_zone[0] / (2.5 * sigma + 3.14 * gamma)
    column = thickest / float(np.max(peak))
    per_zone = [depth * column for depth in per_zone]
    thin = per_zone[0] * planck(lines.nm, zones[0].kelvin)
    depth = peak * column
    area = thin / (1 + 0.5 * depth)  # near enough to choose by; the truth is computed below
    kept = np.flatnonzero(area > faintest * np.sort(area)[-min(20, len(area))])
    lines = lines.where(kept)
    per_zone = [values[kept] for values in per_zone]
    x = np.arange(range_nm[0] - 2, range_nm[1] + 2, STEP_NM)
    radiance = _transfer(x, lines, per_zone, zones, 30.0)
    return Light(
        x, radiance, lines, area[kept], depth[kept], zones, column, tuple(per_zone), shares
    )
