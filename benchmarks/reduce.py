"""Print how fast each step of a reduction is, beside numpy, scipy and lmfit, and how right.

    python benchmarks/reduce.py              speed and, over all families of spectra, accuracy
    python benchmarks/reduce.py speed        speed only
    python benchmarks/reduce.py accuracy 20  accuracy over 20 spectra of each family
    python benchmarks/reduce.py everyday 12  the same over 12 spectra of each everyday instrument
    python benchmarks/reduce.py vices 6      the same by vice: gain steps, roll-off, cut at zero, ...
    python benchmarks/reduce.py closure 8    by vice, concentrations without standards beside the truth
    python benchmarks/reduce.py first        what the first spectrum after an install has to wait for

Times are of the processor, on one core; both sides of each ratio are taken in the same run. The
spectra with known truth are made by `tests/reduction/truth`, which shares no code with the package.
"""

import io
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "reduction"))

import numpy as np
from scipy.optimize import curve_fit
from scipy.special import voigt_profile
from truth import (
    FAMILIES,
    KINDS,
    VICES,
    Score,
    Truth,
    everyday,
    line_free,
    make_spectrum,
    pure_noise,
    score,
    summary,
    with_vice,
)

from labrun.reduction import Reduction, Spectrum, read_spectrum, reduce_spectrum
from labrun.reduction.calibration.closure import concentrations
from labrun.reduction.elements.elements import find_elements
from labrun.reduction.elements.evidence import evidence
from labrun.reduction.elements.identify import identify
from labrun.reduction.elements.state import plasma_state
from labrun.reduction.lines.formula import WEIGHT, with_oxygen
from labrun.reduction.peaks.background import background
from labrun.reduction.peaks.peaks import find_peaks
from labrun.reduction.peaks.profiles import fit_profiles
from labrun.reduction.peaks.voigt import fit_peaks
from labrun.reduction.plasma.lithium_share import NO_CATIONS
from labrun.reduction.spectrum.bad import bridged, mark_bad
from labrun.reduction.spectrum.noise import local_noise
from labrun.reduction.spectrum.resampled import resampled
from labrun.reduction.tables.plot import cation_fraction

CHANNELS = 22_800
REPEATS = 15
FITTED_BY_OTHERS = 20  # enough to know the time of one
FOOT_CHANNELS = 20  # on either side of a peak, for scipy and lmfit
BATCH = 200
FIRST = (
    "import sys, time; from labrun.reduction import read_spectrum, reduce_spectrum; "
    "begin = time.process_time(); reduce_spectrum(read_spectrum(sys.argv[1])); "
    "print(time.process_time() - begin)"
)
SPECTRA = 50  # of each family
EVERYDAY = 6  # of each kind of instrument
NOTHING = 100  # spectra without a line
GOALS = {
    "peaks recall": "0.95, floor 0.93",
    "peaks precision": "0.90, floor 0.83",
    "elements F1": "0.97, floor 0.94",
    "area error": "0.03, floor 0.05",
    "area pull": "0.9-1.2",
    "T error": "0.05, floor 0.10",
}


def csv_of(x: np.ndarray, y: np.ndarray) -> bytes:
    rows = (b"%.4f,%.3f\n" % row for row in zip(x.tolist(), y.tolist(), strict=True))
    return b"wavelength,intensity\n" + b"".join(rows)


def samples() -> list[bytes]:
    """Spectra of the simulated analyser (a pegmatite core), 22,800 channels, as CSV."""
    from labrun.drivers.simulated.twins.shot import ShotMaker

    maker = ShotMaker(core=1, seed=3)
    places = [(0.4, 1.0), (1.2, 3.0), (2.0, 5.0), (2.8, 7.0), (3.6, 9.0), (1.6, 8.0)]
    return [maker.csv({"n": n, "x": x, "y": y, "focus": 1.0}) for n, (x, y) in enumerate(places)]


def timed(step: Callable[..., Any], *given: Any, repeats: int = REPEATS) -> tuple[Any, float]:
    """What the step gives back, and the median milliseconds of a few calls after the first."""
    answer = step(*given)
    took = []
    for _ in range(repeats):
        begin = time.process_time()
        step(*given)
        took.append(1e3 * (time.process_time() - begin))
    return answer, float(np.median(took))


def peak(x, area, centre, sigma, gamma, height):
    return area * voigt_profile(x - centre, abs(sigma), abs(gamma)) + height


def windows(x: np.ndarray, net: np.ndarray, channels: np.ndarray):
    for channel in channels:
        near = slice(max(channel - FOOT_CHANNELS, 0), channel + FOOT_CHANNELS)
        yield x[near], net[near], (0.2 * net[channel], x[channel], 0.05, 0.03, 0.0)


def fit_with_scipy(x: np.ndarray, net: np.ndarray, channels: np.ndarray) -> None:
    for near, counts, first in windows(x, net, channels):
        with suppress(RuntimeError):  # it did not settle; its time counts all the same
            curve_fit(peak, near, counts, first, maxfev=2_000)


def fit_with_lmfit(x: np.ndarray, net: np.ndarray, channels: np.ndarray) -> None:
    from lmfit.models import ConstantModel, VoigtModel

    model = VoigtModel() + ConstantModel()
    for near, counts, (area, centre, sigma, gamma, height) in windows(x, net, channels):
        given = model.make_params(amplitude=area, center=centre, sigma=sigma, c=height)
        given["gamma"].set(value=gamma, vary=True, expr="")
        model.fit(counts, given, x=near)


def show(name: str, ms: float, beside: str = "", other_ms: float = 0.0) -> None:
    ratio = f"{beside} {other_ms:8.2f} ms   {other_ms / ms:6.1f} x" if beside else ""
    print(f"{name:<28}{ms:8.2f} ms   {ratio}")


def speed() -> None:
    texts = samples()
    begin = time.perf_counter()
    reduce_spectrum(read_spectrum(texts[0]))
    print(f"first spectrum, compilation or its cache included: {time.perf_counter() - begin:.1f} s")

    spectrum, read_ms = timed(read_spectrum, texts[0])
    _, loadtxt_ms = timed(lambda: np.loadtxt(io.BytesIO(texts[0]), delimiter=",", skiprows=1))
    show("read", read_ms, "numpy.loadtxt   ", loadtxt_ms)
    x = spectrum.wavelength_nm
    show("shared noise?", timed(resampled, spectrum.intensity)[1])
    bad, ms = timed(mark_bad, spectrum.intensity)
    show("mark bad channels", ms)
    calm = Spectrum(x, bridged(spectrum.intensity, bad.any))
    noise, ms = timed(local_noise, calm.intensity)
    show("noise", ms)
    under, ms = timed(background, calm, noise)
    show("background", ms, *pybaselines_snip(calm))
    channels, ms = timed(find_peaks, calm.intensity - under, noise)
    show("find peaks", ms)
    fits(x, calm.intensity - under, noise, channels)
    profiles, ms = timed(fit_profiles, spectrum, bad.any)
    show(f"all of profiles, {len(profiles.peaks)} peaks", ms)
    identified, ms = timed(identify, x, bad.any, profiles)
    show("offsets, elements, plasma", ms)
    assert identified is not None
    show("evidence", timed(evidence, identified, profiles.peaks)[1])
    show("state of the plasma", timed(plasma_state, profiles.peaks, identified)[1])
    named = timed(find_elements, profiles.peaks, ("Li", "K", "Si", "Na"), (190.0, 961.0))
    show("predominant peaks", named[1])

    def everything() -> None:
        for text in texts:
            reduce_spectrum(read_spectrum(text))

    all_ms = timed(everything)[1] / len(texts)
    show("from CSV to all of it", all_ms)
    print(f"{1e3 / all_ms:.0f} spectra a second on one core (goal 125, floor 50)")
    memory(texts)


def memory(texts: list[bytes]) -> None:
    """Whether a long batch keeps what it has reduced."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for n in range(BATCH):
        reduce_spectrum(read_spectrum(texts[n % len(texts)]))
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(
        f"memory: {after / 1024:.0f} MB, {(after - before) / 1024:.1f} MB more after {BATCH} spectra"
    )


def first() -> None:
    """The processor's time for the first spectrum, with and without compiled code from before."""
    with tempfile.TemporaryDirectory() as cache, tempfile.NamedTemporaryFile("wb") as file:
        file.write(samples()[0])
        file.flush()
        for name in ("compiling everything", "from the cache"):
            answer = subprocess.run(
                [sys.executable, "-c", FIRST, file.name], capture_output=True, text=True,
                check=True, env={**os.environ, "NUMBA_CACHE_DIR": cache},
            )  # fmt: skip
            print(f"first spectrum, {name}: {float(answer.stdout):.1f} s")


def pybaselines_snip(calm: Spectrum) -> tuple[str, float]:
    try:
        from pybaselines.smooth import snip
    except ImportError:
        return "", 0.0
    _, ms = timed(lambda: snip(calm.intensity, max_half_window=88, decreasing=True), repeats=5)
    return "pybaselines.snip", ms


def fits(x: np.ndarray, net: np.ndarray, noise: np.ndarray, channels: np.ndarray) -> None:
    _, fit_ms = timed(fit_peaks, x, net, noise, channels)
    show(f"fit {len(channels)} peaks", fit_ms)
    few = channels[:: max(len(channels) // FITTED_BY_OTHERS, 1)]
    _, scipy_ms = timed(fit_with_scipy, x, net, few, repeats=3)
    show("  one peak", fit_ms / len(channels), "scipy curve_fit ", scipy_ms / len(few))
    with suppress(ImportError):
        _, lmfit_ms = timed(fit_with_lmfit, x, net, few, repeats=2)
        show("  one peak", fit_ms / len(channels), "lmfit VoigtModel", lmfit_ms / len(few))


def scored(truth: Truth) -> Score:
    found = reduce_spectrum(Spectrum(truth.wavelength_nm, truth.intensity))
    peaks, plasma = found.peaks, found.plasma
    kelvin = log10_ne = None
    if plasma is not None:
        log10_ne = plasma.log10_ne
        if plasma.temperature_k is not None and plasma.temperature_error_k is not None:
            kelvin = plasma.temperature_k, plasma.temperature_error_k
    share = cation_fraction(found)
    lithium = None if share is None else (share.share, share.share_error, share.elements)
    return score(
        truth, peaks.centre_nm, np.sqrt(peaks.covariance[:, 1, 1]), peaks.area, peaks.area_error,
        set(found.detected), kelvin, log10_ne, found.medium, lithium,
    )  # fmt: skip


def accuracy(spectra: int) -> None:
    totals = {family: scored_all(make_spectrum, family, spectra) for family in FAMILIES}
    tables = {family: summary(total) for family, total in totals.items()}
    print(f"\n{spectra} spectra each" + " " * 10 + "".join(f"{family:>10}" for family in tables))
    for name in next(iter(tables.values())):
        values = "".join(f"{table[name]:10.3f}" for table in tables.values())
        print(f"{name:<24}{values}   {GOALS.get(name, '')}")
    for family, total in totals.items():
        print(f"{family}: wrong {total.wrong_elements}, missed {total.missed_elements}")


def scored_all(make: Callable[[str, int], Truth], kind: str, spectra: int) -> Score:
    total = Score()
    for number in range(spectra):
        total.add(scored(make(kind, number)))
    return total


def instruments(spectra: int) -> None:
    """One row for each everyday instrument: where something breaks, it is seen here."""
    by_name(everyday, tuple(KINDS), spectra)


NAMES = ("peaks recall", "peaks precision", "elements F1", "area error", "area pull", "T error",
         "T pull", "medium right")  # fmt: skip
WITH_LITHIUM = (
    "spodumene", "muscovite", "K-feldspar", "lepidolite", "brine residue", "basalt glass",
)  # fmt: skip
MAIN = 0.5  # wt %, from which an element counts in the RMSE


def by_name(make: Callable[[str, int], Truth], kinds: tuple[str, ...], spectra: int) -> None:
    print(f"\n{spectra} spectra each      " + "".join(f"{name:>17}" for name in NAMES))
    total = Score()
    for kind in kinds:
        own = scored_all(make, kind, spectra)
        total.add(own)
        table = summary(own)
        print(f"{kind:<24}" + "".join(f"{table[name]:17.3f}" for name in NAMES), flush=True)
    print(f"{'all':<24}" + "".join(f"{summary(total)[name]:17.3f}" for name in NAMES))


def closed(spectra: int) -> None:
    """RMSE of the main elements in wt %, and how many of all values their intervals hold."""
    print(f"\n{spectra} spectra each          told    RMSE    in 68 %     in 95 %")
    whole: list[list[float]] = []
    limits: list[bool] = []
    for kind in VICES:
        rows: list[list[float]] = []
        for number in range(spectra):
            truth = with_vice(kind, number, WITH_LITHIUM)
            found = reduce_spectrum(Spectrum(truth.wavelength_nm, truth.intensity))
            mass = {
                e: n * WEIGHT[e]
                for e, n in truth.shares.items()
                if e in WEIGHT and e not in NO_CATIONS
            }
            whole_mass = sum(m * with_oxygen(e, "oxides") for e, m in mass.items())
            for element, one in concentrations(found, "oxides").items():
                true = 100 * mass.get(element, 0.0) / whole_mass
                if one.wt_percent is None:
                    limits.append(true <= one.high)
                else:
                    rows.append([true, one.wt_percent, one.error, one.low, one.high])
        whole += rows
        show_closed(kind, rows)
    show_closed("all", whole)
    print(f"limits that hold: {np.mean(limits):.3f} of {len(limits)}")


def show_closed(kind: str, rows: list[list[float]]) -> None:
    true, told, error, low, high = np.array(rows).T
    off, main = told - true, true > MAIN
    print(
        f"{kind:<24}{len(true):8}{np.sqrt(np.mean(off[main] ** 2)):8.2f}"
        f"{np.mean(np.abs(off) < error):11.2f}{np.mean((low <= true) & (true <= high)):11.2f}",
        flush=True,
    )


def nothing() -> None:
    for name, make in (("pure noise", pure_noise), ("no line", line_free)):
        claims = sum(bool(claimed(*make(n))) for n in range(NOTHING))
        print(f"{name}: elements claimed in {claims} of {NOTHING} spectra")


def claimed(x: np.ndarray, y: np.ndarray) -> list[str]:
    found: Reduction = reduce_spectrum(Spectrum(x, y))
    return found.detected


def main() -> None:
    what, *rest = sys.argv[1:] or ["all"]
    if what in ("all", "speed"):
        speed()
    if what in ("all", "accuracy"):
        accuracy(int(rest[0]) if rest else SPECTRA)
        nothing()
    if what in ("all", "everyday"):
        instruments(int(rest[0]) if rest else EVERYDAY)
    if what in ("all", "vices"):
        by_name(with_vice, tuple(VICES), int(rest[0]) if rest else EVERYDAY)
    if what in ("all", "closure"):
        closed(int(rest[0]) if rest else EVERYDAY)
    if what in ("all", "first"):
        first()


if __name__ == "__main__":
    main()
