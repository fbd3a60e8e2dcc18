"""Prepare all kernels before the first spectrum: load them, or compile them on first use."""

import numpy as np

from .lines.air import to_air
from .lines.lines import lines_of
from .reduce import reduce_spectrum
from .spectrum.read import read_spectrum

ELEMENTS, STRONGEST = ("Ca", "Fe", "Ti"), 60  # enough to be found, and to tell a temperature
KT_EV = 0.86  # 10,000 K
BRIGHTEST, HALF_WIDTH_NM = 40_000.0, 0.08


def warm_up() -> None:
    """Reduce a made spectrum that takes every usual step: noise, peaks, elements, a plasma."""
    wavelength = np.linspace(190.0, 950.0, 22_800)
    counts = 200 + np.random.default_rng(1).normal(0, 5, len(wavelength))
    for element in ELEMENTS:
        lines = lines_of(element)
        light = lines.g_k * lines.a_ki_per_s / lines.wavelength_nm * np.exp(-lines.e_k_ev / KT_EV)
        most = np.argsort(-light)[:STRONGEST]
        tops = BRIGHTEST * light[most] / light.max()
        for centre, top in zip(to_air(lines.wavelength_nm[most]), tops, strict=True):
            counts += top / (1 + ((wavelength - centre) / HALF_WIDTH_NM) ** 2)
    rows = (f"{x:.4f},{y:.1f}" for x, y in zip(wavelength, counts, strict=True))
    reduce_spectrum(read_spectrum("\n".join(("wavelength,intensity", *rows)).encode()))
