"""How good concentrations are, on rocks whose composition is known: by element and method.

Standards and unknowns are made by the generator of the tests, which shares no code with the package:
light is transferred through a hot core and a cool shell, so that strong lines absorb themselves;
each sample has a plasma of its own (temperature, electrons, ablated mass: the matrix effect), each
shot its own brightness and photon noise, and the instrument loses light while it measures (drift).
Transition probabilities are off by their accuracy classes, the same in all rocks of a series.
Prints RMSEP, bias, and how often the 68 and 95 % intervals hold the truth, by element and method;
then, of samples without an element, with its LOD, and with twice that, how many are said to have it.
"""

import argparse
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "reduction"))

from truth.atoms import lines_of
from truth.instrument import Instrument, record, see
from truth.light import Zone, opacity, shine, widths
from truth.samples import WEIGHT

from labrun.reduction.calibration.calibrate import Choices, Shot, calibrate
from labrun.reduction.calibration.calibration import (
    AREA,
    LIGHT,
    Calibration,
    Card,
    Concentration,
    asked_for,
)
from labrun.reduction.calibration.closure import concentrations, one_point
from labrun.reduction.calibration.standards import Standard, Standards
from labrun.reduction.lines.formula import with_oxygen
from labrun.reduction.reduce import Reduction, reduce_spectrum
from labrun.reduction.spectrum.spectrum import FloatArray, Spectrum

RANGE_NM, CHANNELS, FWHM_NM = (240.0, 900.0), 8_192, 0.2
MAJORS = {  # wt % of elements in silicate rocks, drawn evenly
    "Si": (20, 35), "Al": (4, 11), "Fe": (0.7, 9), "Mg": (0.1, 6), "Ca": (0.3, 8), "Na": (0.7, 4),
    "K": (0.2, 5), "Ti": (0.05, 1.3), "Mn": (0.01, 0.16),
}  # fmt: skip
BASALTS = {
    "Si": (20.5, 24.5), "Al": (6, 9.5), "Fe": (5, 13), "Mg": (2, 8), "Ca": (5, 9), "Na": (1, 3.2),
    "K": (0.1, 1.5), "Ti": (0.4, 2.2), "Mn": (0.08, 0.2),
}  # fmt: skip
TRACES = {"Li": (5e-4, 0.3), "Rb": (1e-3, 0.1), "Sr": (2e-3, 0.1), "Ba": (3e-3, 0.15)}  # in logs
CURVES = {  # methods by a curve: what `labrun calibrate standards` is asked for
    "lines": Choices(pls=False),  # lines and normalisation as cross-validates best
    "area": Choices(by=AREA, pls=False),
    "light": Choices(by=LIGHT, pls=False),
    "internal": Choices(by="O", pls=False),  # all these rocks are oxides: 42 to 51 wt % of oxygen
    "pls": Choices(pls=True),
    "best": Choices(pls=None),  # of each element the better of lines and PLS
}
CLOSED = {"closure": 0, "one-point 1": 1, "one-point 3": 3}  # how many standards tell a factor
METHODS = (*CURVES, *CLOSED)
USUAL = ("lines", "closure", "one-point 1")
LEAST_CLOSED = 0.5  # wt %: a closure is of what makes up a rock
AT_LOD = 18  # shots of each series, of rocks that lack elements or have them at their LOD
ASKED = asked_for([*MAJORS, *TRACES], None)
WITHOUT = 0.1  # of the samples, for each trace
NONE = 1e-9  # wt %: far too little for a line, so that all rocks have the same list of them
REFERENCE_DEPTH = 8.0  # optical depth of the thickest line of a mean rock
SPREAD = {"kelvin": 0.04, "electrons": 0.2, "column": 0.2, "shell": 0.06}
UNLIKE_PART, UNLIKE_KELVIN, UNLIKE_SPREAD = (
    (0.005, 0.6),
    (0.45, 0.7),
    0.3,
)  # of a shell: share, heat
SHOT, DRIFT, BRIGHTEST, CONTINUUM = 0.12, 0.10, 30_000.0, 300.0

Ends = Mapping[str, tuple[float, float]]  # of wt %, by element
Sample = tuple[dict[str, float], list[Reduction]]  # wt % by element, and its shots
Row = tuple[str, float, Concentration]  # element, truth in wt %, what is told


def rock(rng: np.random.Generator, majors: Ends = MAJORS) -> dict[str, float]:
    """wt % by element; the rest is oxygen."""
    found = {name: rng.uniform(*ends) for name, ends in majors.items()}
    for name, ends in TRACES.items():
        found[name] = 0.0 if rng.random() < WITHOUT else float(np.exp(rng.uniform(*np.log(ends))))
    return found


def shares_of(wt: dict[str, float]) -> dict[str, float]:
    atoms = {name: max(one, NONE) / WEIGHT[name] for name, one in wt.items()}
    atoms["O"] = (100 - sum(wt.values())) / WEIGHT["O"]
    total = sum(atoms.values())
    return {name: 0.92 * one / total for name, one in atoms.items()} | {"Ar": 0.075, "H": 0.005}


@dataclass(frozen=True, slots=True)
class Scattered:
    """Errors of transition probabilities, the same in all rocks: whole accuracy classes, of which `shine`
    takes half."""

    seed: int

    def standard_normal(self, n: int) -> FloatArray:
        return 2 * np.random.default_rng(self.seed).standard_normal(n)


def thickest(shares, zone: Zone, off: Scattered | None) -> float:
    """Of its lines' optical depths for one column of atoms, arbitrary unit."""
    lines = lines_of(tuple(sorted(shares)))
    lines = lines.where((lines.nm > RANGE_NM[0] - 1) & (lines.nm < RANGE_NM[1] + 1))
    sigma, gamma = widths(lines, zone)
    depth = opacity(lines, shares, zone) / (2.5 * sigma + 3.14 * gamma)
    if off is not None:
        depth = depth * np.exp(0.5 * lines.uncertain * off.standard_normal(len(lines.nm)))
    return float(np.max(depth))


class Laboratory:
    """One instrument, and the light it has lost so far."""

    def __init__(self, seed: int, exact: bool = False, unlike_shell: bool = False) -> None:
        self.rng = np.random.default_rng(seed)
        self.shell: tuple[float, float] | None = (
            None  # share of the atoms, and heat beside the core's
        )
        if unlike_shell:
            own = np.random.default_rng(20_000 + seed)
            heat = own.uniform(*UNLIKE_KELVIN)
            self.shell = float(np.exp(own.uniform(*np.log(UNLIKE_PART)))), float(heat)
        self.off = None if exact else Scattered(10_000 + seed)
        axis = np.linspace(*RANGE_NM, CHANNELS)
        self.instrument = Instrument(
            axis, np.empty(0), np.array([0.02]), np.array([FWHM_NM]), "air", 0.0, 0.4, 6.0, 65_535.0, 1
        )  # fmt: skip
        mean = {name: float(np.mean(ends)) for name, ends in MAJORS.items()}
        mean |= {name: float(np.exp(np.mean(np.log(ends)))) for name, ends in TRACES.items()}
        self.depth = REFERENCE_DEPTH / thickest(shares_of(mean), Zone(11_000, 1e17, 1.0), self.off)
        self.scale = BRIGHTEST / float(self._light(mean, plain=True).max())
        self.measured = 0

    def _light(self, wt, plain=False):
        def draw(what):
            return 1.0 if plain else float(np.exp(SPREAD[what] * self.rng.standard_normal()))

        kelvin, electrons = 11_000 * draw("kelvin"), 1e17 * draw("electrons")
        shell, heat = 0.12 + (0.0 if plain else SPREAD["shell"] * self.rng.uniform(-1, 1)), 0.7
        if self.shell is not None:
            part, heat = self.shell
            off = 0.0 if plain else UNLIKE_SPREAD * self.rng.standard_normal()
            shell = min(part * float(np.exp(off)), 0.7)
        zones = (Zone(kelvin, electrons, 1 - shell), Zone(heat * kelvin, 0.3 * electrons, shell))
        shares = shares_of(wt)
        depth = self.depth * draw("column") * thickest(shares, zones[0], self.off)
        light = shine(shares, zones, RANGE_NM, depth, 1e-3, self.off)
        return see(light.nm, light.radiance, self.instrument)

    def shots(self, wt: dict[str, float], n: int, of: int) -> np.ndarray:
        """Counts of n shots at a rock, shape (n, channels); `of`: samples in the whole series."""
        net = self.scale * self._light(wt) * (1 - DRIFT * self.measured / of)
        self.measured += 1
        found = []
        for _ in range(n):
            bright = float(np.exp(SHOT * self.rng.standard_normal()))
            found.append(record(bright * (net + CONTINUUM), self.instrument, self.rng)[0])
        return np.array(found)


@dataclass(frozen=True, slots=True)
class Series:
    """What one instrument measured: its axis, (wt %, reductions of shots) of standards and unknowns."""

    laboratory: Laboratory
    standards: list[Sample]
    unknowns: list[Sample]
    response: FloatArray | float

    @property
    def axis_nm(self) -> FloatArray:
        return self.laboratory.instrument.axis_nm

    def reduced(self, counts: FloatArray) -> Reduction:
        return reduce_spectrum(Spectrum(self.axis_nm, counts * self.response), ASKED)


def measured(
    seed: int, n_standards: int, n_unknowns: int, n_shots: int, uneven: bool, exact: bool,
    unlike_shell: bool, majors: Ends = MAJORS,
) -> Series:  # fmt: skip
    """Standards and unknowns, one series in a drawn order."""
    laboratory = Laboratory(seed, exact, unlike_shell)
    both = n_standards + n_unknowns
    rocks = [rock(laboratory.rng, majors) for _ in range(both)]
    order = laboratory.rng.permutation(both)
    counts = {int(k): laboratory.shots(rocks[k], n_shots, both) for k in order}
    response = unlike(laboratory.instrument.axis_nm) if uneven else 1.0
    series = Series(laboratory, [], [], response)
    for k in range(both):
        sample = rocks[k], [series.reduced(one) for one in counts[k]]
        (series.standards if k < n_standards else series.unknowns).append(sample)
    return series


def unlike(axis: FloatArray) -> FloatArray:
    """The response of an instrument that sees little at both ends, and less beyond a seam at 470 nm."""
    ends = np.clip((920 - axis) / 200, 0.05, 1) / (1 + np.exp((270 - axis) / 12))
    return ends * np.where(axis < 470, 1.0, 0.3)


def calibrated(series: Series, choices: Choices) -> Calibration:
    """By the series' standards; says which elements have no curve, and why."""
    known = [(f"s{k}", *sample) for k, sample in enumerate(series.standards)]
    table = Standards(tuple(Standard(name, wt, ()) for name, wt, _ in known), ())
    shots = {name: [Shot(name, one) for one in reduced] for name, _, reduced in known}
    made = calibrate(table, shots, choices)
    for refused in made.refused:
        print("not calibrated:", refused)
    axis = series.axis_nm
    card = Card("", "", "", "", "", 0, 0, "", len(axis), axis[0], axis[-1], (0.0, 1e30), None)
    return Calibration(card, made.elements, likeness=made.likeness)


def by_curve(series: Series, made: Calibration) -> Iterator[Row]:
    """Each unknown by the mean of its shots."""
    for wt, shots in series.unknowns:
        for name, told in made.concentrations(series.axis_nm, shots).items():
            yield name, wt[name], told


def by_closure(series: Series, n: int) -> Iterator[Row]:
    """A shot of each unknown closed as oxides, by n standards; wt % of oxides that make 100 %."""
    points = one_point(series.standards[:n]) if n else None
    for wt, shots in series.unknowns:
        whole = sum(c * with_oxygen(name, "oxides") for name, c in wt.items()) / 100
        for name, told in concentrations(shots[0], "oxides", points).items():
            if wt.get(name, 0.0) / whole > LEAST_CLOSED:
                yield name, wt[name] / whole, told


def at_limits(series: Series, made: Calibration) -> Iterator[tuple[str, float, int, bool]]:
    """(element, LOD, how many LOD of it a rock has: 0, 1 or 2, whether it is said to be above LOD)."""
    rng = series.laboratory.rng
    for _ in range(AT_LOD):
        wt, times = rock(rng), {name: int(rng.integers(3)) for name in made.elements}
        wt |= {name: n * made.elements[name].lod for name, n in times.items()}
        shot = series.reduced(series.laboratory.shots(wt, 1, 2 * series.laboratory.measured)[0])
        for name, told in made.concentrations(series.axis_nm, [shot]).items():
            yield name, made.elements[name].lod, times[name], "below LOD" not in told.flags


def main() -> None:
    own = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    own.add_argument("--standards", type=int, default=14)
    own.add_argument("--unknowns", type=int, default=16)
    own.add_argument("--shots", type=int, default=5)
    own.add_argument(
        "--series", type=int, nargs="+", default=[1, 2, 3, 4, 5, 6], help="numbers of them"
    )
    own.add_argument(
        "--methods", nargs="+", choices=METHODS, default=USUAL, metavar="METHOD",
        help=f"of {', '.join(METHODS)} (pls and best need scikit-learn); usually {', '.join(USUAL)}",
    )  # fmt: skip
    own.add_argument(
        "--unknown-response", action="store_true", help="measure with an uneven instrument"
    )
    own.add_argument(
        "--exact", action="store_true",
        help="the lines' true transition probabilities are the table's, as no real line's are",
    )  # fmt: skip
    own.add_argument(
        "--unlike-shell", action="store_true",
        help="each series has a shell of its own: 0.5 to 60 % of the atoms at 0.45 to 0.7 of the temperature",
    )  # fmt: skip
    own.add_argument("--basalts", action="store_true", help="of 5 to 13 %% iron, not of all rocks")
    asked = own.parse_args()
    print(f"{asked.standards} standards, {asked.unknowns} unknowns, {asked.shots} shots each")
    rows: dict[str, list[Row]] = {method: [] for method in asked.methods}
    limits: list[tuple[str, float, int, bool]] = []
    for seed in asked.series:
        print(f"\nseries {seed}", flush=True)
        series = measured(
            seed,
            asked.standards,
            asked.unknowns,
            asked.shots,
            asked.unknown_response,
            asked.exact,
            asked.unlike_shell,
            BASALTS if asked.basalts else MAJORS,
        )
        for method in asked.methods:
            if method in CLOSED:
                rows[method] += by_closure(series, CLOSED[method])
                continue
            made = calibrated(series, CURVES[method])
            rows[method] += by_curve(series, made)
            if method == asked.methods[0]:
                limits += at_limits(series, made)
    print(f"\n{by_element(rows)}\n\n{limits_held(rows)}")
    if limits:
        print(f"\n{counted(limits)}")


def by_element(rows: Mapping[str, Sequence[Row]]) -> str:
    """A row for each element: of each method RMSEP (bias), per cent in 68 and 95 % intervals, values."""
    lines = [f"| | mean | {' | '.join(rows)} |", f"| --- | --- |{' --- |' * len(rows)}"]
    for name in (*MAJORS, *TRACES, "all"):
        own = {
            method: [
                (c, told)
                for element, c, told in of
                if name in (element, "all") and told.wt_percent is not None
            ]
            for method, of in rows.items()
        }
        truths = [c for read in own.values() for c, _ in read]
        if truths:
            cells = " | ".join(_cell(read, name == "all") for read in own.values())
            lines.append(
                f"| {name} | {'' if name == 'all' else f'{np.mean(truths):.2g}'} | {cells} |"
            )
    return "\n".join(lines)


def _cell(read: Sequence[tuple[float, Concentration]], together: bool) -> str:
    if not read:
        return ""
    error = np.array([told.wt_percent - c for c, told in read])
    in_68 = 100 * np.mean([abs(e.wt_percent - c) <= e.error for c, e in read])
    in_95 = 100 * np.mean([e.low <= c <= _end(e) for c, e in read])
    off = "" if together else f"{np.sqrt(np.mean(error**2)):.2g} ({error.mean():+.1g}), "
    return f"{off}{in_68:.0f}/{in_95:.0f} of {len(read)}"


def limits_held(rows: Mapping[str, Sequence[Row]]) -> str:
    """How often what is told to be below LOD is below its upper limit."""
    said = []
    for method, of in rows.items():
        held = [c <= _end(told) for _, c, told in of if "below LOD" in told.flags]
        if held:
            said.append(f"{method}: {100 * np.mean(held):.0f} % of {len(held)} upper limits hold")
    return "\n".join(said)


def counted(limits: Sequence[tuple[str, float, int, bool]]) -> str:
    """False positives and negatives of one shot, by element."""
    lines = [
        "| | LOD | without it, told | with one LOD, not told | with two LOD, not told |",
        "| --- | --- | --- | --- | --- |",
    ]
    for name in (*MAJORS, *TRACES, "all"):
        own = [rest for element, *rest in limits if name in (element, "all")]
        cells = ["" if name == "all" or not own else f"{np.median([lod for lod, _, _ in own]):.2g}"]
        for n in range(3):
            told = [yes for _, times, yes in own if times == n]
            cells.append(f"{sum(told) if n == 0 else len(told) - sum(told)} of {len(told)}")
        if own:
            lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _end(told: Concentration) -> float:
    return np.inf if told.high is None else told.high


if __name__ == "__main__":
    main()
