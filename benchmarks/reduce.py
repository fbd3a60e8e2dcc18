"""Print the milliseconds that each step of a reduction takes, beside scipy and numpy.

Run it as `python benchmarks/reduce.py`. The figures that count are the ratios: both sides of each
are taken in the same run, on one core.
"""

import io
import os
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from scipy.optimize import curve_fit
from scipy.special import voigt_profile

from labrun.reduction import Spectrum, read_spectrum, reduce_spectrum
from labrun.reduction.background import background, despike
from labrun.reduction.noise import local_noise
from labrun.reduction.peaks import find_peaks
from labrun.reduction.voigt import fit_peaks

CHANNELS, N_LINES = 22_800, 200
REPEATS = 15
FITTED_BY_SCIPY = 20  # enough to know the time of one
FOOT_CHANNELS = 20  # on either side of a peak, for scipy


def sample(seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """A spectrum of 200 Voigt lines on a continuum, with photon noise."""
    rng = np.random.default_rng(seed)
    x = np.linspace(190, 961, CHANNELS)
    y = 300 + 200 * np.exp(-(((x - 450) / 150) ** 2))
    for centre in rng.uniform(195, 955, N_LINES):
        area, sigma, gamma = 10 ** rng.uniform(1.2, 4), *rng.uniform(0.02, 0.08, 2)
        y += area * voigt_profile(x - centre, sigma, gamma)
    return x, y + rng.normal(0, 1, CHANNELS) * np.sqrt(8.0**2 + y)


def timed(step: Callable[..., Any], *given: Any, repeats: int = REPEATS) -> tuple[Any, float]:
    """What the step gives back, and the median milliseconds of a few calls after the first."""
    answer = step(*given)
    took = []
    for _ in range(repeats):
        begin = time.perf_counter()
        step(*given)
        took.append(1e3 * (time.perf_counter() - begin))
    return answer, float(np.median(took))


def peak(x, area, centre, sigma, gamma, height):
    return area * voigt_profile(x - centre, abs(sigma), abs(gamma)) + height


def fit_with_scipy(x: np.ndarray, net: np.ndarray, channels: np.ndarray) -> None:
    for channel in channels:
        near = slice(max(channel - FOOT_CHANNELS, 0), channel + FOOT_CHANNELS)
        first = (0.2 * net[channel], x[channel], 0.05, 0.03, 0.0)
        with suppress(RuntimeError):  # it did not settle; its time counts all the same
            curve_fit(peak, x[near], net[near], first, maxfev=2_000)


def show(name: str, ms: float, beside: str = "", other_ms: float = 0.0) -> None:
    ratio = f"{beside} {other_ms:8.2f} ms   {other_ms / ms:6.1f} x" if beside else ""
    print(f"{name:<28}{ms:8.2f} ms   {ratio}")


def main() -> None:
    x, y = sample()
    text = b"wavelength,intensity\n" + b"".join(
        b"%.4f,%.3f\n" % row for row in zip(x.tolist(), y.tolist(), strict=True)
    )
    begin = time.perf_counter()
    reduce_spectrum(read_spectrum(text))
    print(f"first spectrum, compilation or its cache included: {time.perf_counter() - begin:.1f} s")

    spectrum, read_ms = timed(read_spectrum, text)
    _, loadtxt_ms = timed(lambda: np.loadtxt(io.BytesIO(text), delimiter=",", skiprows=1))
    noise, noise_ms = timed(local_noise, spectrum.intensity)
    calm, despike_ms = timed(despike, spectrum.intensity, noise)
    calm = Spectrum(spectrum.wavelength_nm, calm)
    under, background_ms = timed(background, calm, noise)
    net = calm.intensity - under
    channels, peaks_ms = timed(find_peaks, net, noise)
    _, fit_ms = timed(fit_peaks, x, net, noise, channels)
    few = channels[:: max(len(channels) // FITTED_BY_SCIPY, 1)]
    _, scipy_ms = timed(fit_with_scipy, x, net, few, repeats=3)
    _, reduce_ms = timed(reduce_spectrum, spectrum)
    _, all_ms = timed(lambda: reduce_spectrum(read_spectrum(text)))

    show("read", read_ms, "numpy.loadtxt   ", loadtxt_ms)
    show("noise", noise_ms)
    show("despike", despike_ms)
    show("background", background_ms)
    show("find peaks", peaks_ms)
    show(f"fit {len(channels)} peaks", fit_ms)
    show("  one peak", fit_ms / len(channels), "scipy curve_fit ", scipy_ms / len(few))
    show("reduce_spectrum", reduce_ms)
    show("from CSV to elements", all_ms)
    print(f"{1e3 / all_ms:.0f} spectra a second on one core")


if __name__ == "__main__":
    main()
