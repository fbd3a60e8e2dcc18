"""How good concentrations by `labrun calibrate standards` are, on rocks whose composition is known.

Standards and unknowns are made by the generator of the tests, which shares no code with the package:
light is transferred through a hot core and a cool shell, so that strong lines absorb themselves;
each sample has a plasma of its own (temperature, electrons, ablated mass: the matrix effect), each
shot its own brightness and photon noise, and the instrument loses light while it measures (drift).
Prints RMSEP, bias, and how often the 68 and 95 % intervals hold the truth, by element; then what
the limits of detection are worth on samples without and with so much of the element.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "reduction"))

from truth.atoms import lines_of
from truth.instrument import Instrument, record, see
from truth.light import Zone, opacity, shine, widths
from truth.samples import WEIGHT

from labrun.reduction.calibration.calibrate import Choices, Shot, calibrate
from labrun.reduction.calibration.calibration import Calibration, Card, asked_for
from labrun.reduction.calibration.closure import concentrations, one_point
from labrun.reduction.calibration.standards import Standard, Standards
from labrun.reduction.lines.formula import with_oxygen
from labrun.reduction.reduce import reduce_spectrum
from labrun.reduction.spectrum.spectrum import Spectrum

RANGE_NM, CHANNELS, FWHM_NM = (240.0, 900.0), 8_192, 0.2
MAJORS = {  # wt % of elements in silicate rocks, drawn evenly
    "Si": (20, 35), "Al": (4, 11), "Fe": (0.7, 9), "Mg": (0.1, 6), "Ca": (0.3, 8), "Na": (0.7, 4),
    "K": (0.2, 5), "Ti": (0.05, 1.3), "Mn": (0.01, 0.16),
}  # fmt: skip
TRACES = {"Li": (5e-4, 0.3), "Rb": (1e-3, 0.1), "Sr": (2e-3, 0.1), "Ba": (3e-3, 0.15)}  # in logs
MODELS = {"lines": False, "pls": True, "both": None}
LEAST_CLOSED = 0.5  # wt %
WITHOUT = 0.1  # of the samples, for each trace
REFERENCE_DEPTH = 8.0  # optical depth of the thickest line of a mean rock
SPREAD = {"kelvin": 0.04, "electrons": 0.2, "column": 0.2, "shell": 0.06}
SHOT, DRIFT, BRIGHTEST, CONTINUUM = 0.12, 0.10, 30_000.0, 300.0


def rock(rng: np.random.Generator) -> dict[str, float]:
    """wt % by element; the rest is oxygen."""
    found = {name: rng.uniform(*ends) for name, ends in MAJORS.items()}
    for name, ends in TRACES.items():
        found[name] = 0.0 if rng.random() < WITHOUT else float(np.exp(rng.uniform(*np.log(ends))))
    return found


def shares_of(wt: dict[str, float]) -> dict[str, float]:
    atoms = {name: one / WEIGHT[name] for name, one in wt.items() if one > 0}
    atoms["O"] = (100 - sum(wt.values())) / WEIGHT["O"]
    total = sum(atoms.values())
    return {name: 0.92 * one / total for name, one in atoms.items()} | {"Ar": 0.075, "H": 0.005}


def thickest(shares, zone: Zone) -> float:
    """Of its lines' optical depths for one column of atoms, arbitrary unit."""
    lines = lines_of(tuple(sorted(shares)))
    lines = lines.where((lines.nm > RANGE_NM[0] - 1) & (lines.nm < RANGE_NM[1] + 1))
    sigma, gamma = widths(lines, zone)
    return float(np.max(opacity(lines, shares, zone) / (2.5 * sigma + 3.14 * gamma)))


class Laboratory:
    """One instrument, and the light it has lost so far."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        axis = np.linspace(*RANGE_NM, CHANNELS)
        self.instrument = Instrument(
            axis, np.empty(0), np.array([0.02]), np.array([FWHM_NM]), "air", 0.0, 0.4, 6.0, 65_535.0, 1
        )  # fmt: skip
        mean = {name: float(np.mean(ends)) for name, ends in MAJORS.items()}
        mean |= {name: float(np.exp(np.mean(np.log(ends)))) for name, ends in TRACES.items()}
        self.depth = REFERENCE_DEPTH / thickest(shares_of(mean), Zone(11_000, 1e17, 1.0))
        self.scale = BRIGHTEST / float(self._light(mean, plain=True).max())
        self.measured = 0

    def _light(self, wt, plain=False):
        def draw(what):
            return 1.0 if plain else float(np.exp(SPREAD[what] * self.rng.standard_normal()))

        kelvin, electrons = 11_000 * draw("kelvin"), 1e17 * draw("electrons")
        shell = 0.12 + (0.0 if plain else SPREAD["shell"] * self.rng.uniform(-1, 1))
        zones = (Zone(kelvin, electrons, 1 - shell), Zone(0.7 * kelvin, 0.3 * electrons, shell))
        shares = shares_of(wt)
        depth = self.depth * draw("column") * thickest(shares, zones[0])
        light = shine(shares, zones, RANGE_NM, depth, 1e-3, None)
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


def measure(seed: int, n_standards: int, n_unknowns: int, n_shots: int):
    """Standards and unknowns, one series in a drawn order: (wt %, counts of shots) of each."""
    laboratory = Laboratory(seed)
    both = n_standards + n_unknowns
    rocks = [rock(laboratory.rng) for _ in range(both)]
    order = laboratory.rng.permutation(both)
    counts = {int(k): laboratory.shots(rocks[k], n_shots, both) for k in order}
    made = [(rocks[k], counts[k]) for k in range(both)]
    return laboratory.instrument.axis_nm, made[:n_standards], made[n_standards:]


def calibrated(axis, standards, pls: bool | None) -> Calibration:
    names = [*MAJORS, *TRACES]
    asked = asked_for(names, None)
    table = Standards(tuple(Standard(f"s{k}", wt, ()) for k, (wt, _) in enumerate(standards)), ())
    shots = {
        f"s{k}": [Shot(f"s{k}", reduce_spectrum(Spectrum(axis, one), asked)) for one in counts]
        for k, (_, counts) in enumerate(standards)
    }
    made = calibrate(table, shots, Choices(pls=pls))
    for refused in made.refused:
        print("\nNot calibrated:", refused)
    card = Card("", "", "", "", "", 0, 0, "", len(axis), axis[0], axis[-1], (0.0, 1e30), None)
    return Calibration(card, made.elements, likeness=made.likeness)


def judge(axis, unknowns, made: Calibration):
    """Rows (element, truth, Concentration) of all unknowns, each the mean of its shots."""
    rows = []
    for wt, counts in unknowns:
        asked = asked_for([*MAJORS, *TRACES], None)
        shots = [reduce_spectrum(Spectrum(axis, one), asked) for one in counts]
        found = made.concentrations(axis, shots)
        rows += [(name, wt[name], told) for name, told in found.items()]
    return rows


def table(rows, made: Calibration) -> str:
    lines = [
        "| | signal, curve | standards, wt % | LOD | RMSECV | RMSEP | bias | in 68 % | in 95 % | < LOD |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]  # fmt: skip
    total = np.zeros(4)
    for name, one in made.elements.items():
        told = [(c, e) for n, c, e in rows if n == name]
        read = [(c, e) for c, e in told if e.wt_percent is not None]
        below = [c for c, e in told if "below LOD" in e.flags]
        error = np.array([e.wt_percent - c for c, e in read])
        in_68 = sum(abs(e.wt_percent - c) <= e.error for c, e in read)
        in_95 = sum(e.low <= c <= _end(e) for c, e in read)
        total += in_68, len(read), in_95, len(read)
        kind = "straight" if len(one.curve.coefficients) == 2 else "quadratic"
        kind = kind if one.pls is None else f"PLS, {one.pls.components} components"
        if not len(read):
            continue
        lines.append(
            f"| {name} | {one.by}, {kind} | {one.lowest:.2g} to {one.curve.highest:.2g} | {one.lod:.2g} "
            f"| {one.rmsecv:.2g} | {np.sqrt(np.mean(error**2)):.2g} | {error.mean():+.2g} "
            f"| {in_68} of {len(read)} | {in_95} of {len(read)} "
            f"| {len(below)}: {sum(c < one.lod for c in below)} |"
        )
    lines.append(
        f"| all | | | | | | | {100 * total[0] / total[1]:.0f} % | {100 * total[2] / total[3]:.0f} % | |"
    )
    return "\n".join(lines)


def main() -> None:
    own = argparse.ArgumentParser(description=__doc__)
    own.add_argument("--standards", type=int, default=14)
    own.add_argument("--unknowns", type=int, default=16)
    own.add_argument("--shots", type=int, default=5)
    own.add_argument(
        "--series", type=int, nargs="+", default=[1, 2, 3, 4, 5, 6], help="numbers of them"
    )
    own.add_argument(
        "--model", choices=MODELS, default="lines",
        help="curves of lines, PLS of whole spectra, or of each element the better",
    )  # fmt: skip
    own.add_argument(
        "--closed", action="store_true",
        help="a shot of each unknown closed as oxides, without standards and by one and three of them",
    )  # fmt: skip
    own.add_argument(
        "--unknown-response", action="store_true", help="with --closed: of an uneven instrument"
    )
    asked = own.parse_args()
    print(f"{asked.standards} standards, {asked.unknowns} unknowns, {asked.shots} shots each")
    all_rows, closed_rows = [], []
    for seed in asked.series:
        axis, standards, unknowns = measure(seed, asked.standards, asked.unknowns, asked.shots)
        if asked.closed:
            response = unlike(axis) if asked.unknown_response else 1.0
            closed_rows += closed(axis, standards, unknowns, response)
            continue
        made = calibrated(axis, standards, MODELS[asked.model])
        rows = judge(axis, unknowns, made)
        all_rows += [
            (element, truth, told, made.elements[element]) for element, truth, told in rows
        ]
        print(f"\nSeries {seed}\n\n{table(rows, made)}")
    if asked.closed:
        print(closed_table(closed_rows))
        return
    print(f"\nAll series\n\n{by_element(all_rows)}\n\n{coverage(all_rows)}")


def unlike(axis):
    """The response of an instrument that sees little at both ends, and less beyond a seam at 470 nm."""
    ends = np.clip((920 - axis) / 200, 0.05, 1) / (1 + np.exp((270 - axis) / 12))
    return ends * np.where(axis < 470, 1.0, 0.3)


def closed(axis, standards, unknowns, response):
    """Rows (standards used, element, truth, Concentration) above `LEAST_CLOSED`."""
    both = [
        [
            (wt, [reduce_spectrum(Spectrum(axis, one)) for one in counts[:n]])
            for wt, counts in samples
        ]
        for samples, n in ((standards[:3], None), (unknowns, 1))
    ]
    rows = []
    for n in (0, 1, 3):
        points = one_point(both[0][:n]) if n else None
        for wt, shots in both[1]:
            whole = sum(c * with_oxygen(name, "oxides") for name, c in wt.items()) / 100
            told = concentrations(shots[0], "oxides", points)
            rows += [
                (n, name, wt[name] / whole, one)
                for name, one in told.items()
                if one.wt_percent is not None and wt.get(name, 0.0) / whole > LEAST_CLOSED
            ]
    return rows


def closed_table(rows) -> str:
    lines = [
        "| standards | values | RMSE | bias | in 68 % | in 95 % |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for n in (0, 1, 3):
        own = [(truth, told) for k, _, truth, told in rows if k == n]
        error = np.array([told.wt_percent - truth for truth, told in own])
        in_68 = np.mean([abs(told.wt_percent - truth) <= told.error for truth, told in own])
        in_95 = np.mean([told.low <= truth <= told.high for truth, told in own])
        lines.append(
            f"| {n} | {len(own)} | {np.sqrt(np.mean(error**2)):.2f} | {error.mean():+.2f} "
            f"| {100 * in_68:.0f} % | {100 * in_95:.0f} % |"
        )
    return "\n".join(lines)


def by_element(rows) -> str:
    """All series together."""
    lines = [
        "| | series with a curve | median LOD | RMSEP | mean | bias | in 68 % | in 95 % | < LOD |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for name in dict.fromkeys(row[0] for row in rows):
        own = [row[1:] for row in rows if row[0] == name]
        read = [(c, told) for c, told, _ in own if told.wt_percent is not None]
        error = np.array([told.wt_percent - c for c, told in read])
        curves = {id(one): one.lod for _, _, one in own}
        below = [(c, one.lod) for c, told, one in own if "below LOD" in told.flags]
        lines.append(
            f"| {name} | {len(curves)} | {np.median(list(curves.values())):.2g} "
            f"| {np.sqrt(np.mean(error**2)):.2g} | {np.mean([c for c, _ in read]):.2g} | {error.mean():+.2g} "
            f"| {sum(abs(e.wt_percent - c) <= e.error for c, e in read)} of {len(read)} "
            f"| {sum(e.low <= c <= _end(e) for c, e in read)} of {len(read)} "
            f"| {len(below)}: {sum(c < lod for c, lod in below)} |"
        )
    return "\n".join(lines)


def coverage(rows) -> str:
    """How often intervals hold, and what the limits of detection are worth."""
    read = [(truth, told) for _, truth, told, _ in rows if told.wt_percent is not None]
    in_68 = np.mean([abs(told.wt_percent - truth) <= told.error for truth, told in read])
    in_95 = np.mean([told.low <= truth <= _end(told) for truth, told in read])
    below = [(truth, told) for _, truth, told, _ in rows if "below LOD" in told.flags]
    held = np.mean([truth <= _end(told) for truth, told in below])
    blank = [told for _, truth, told, _ in rows if truth == 0]
    claimed = sum(told.wt_percent is not None for told in blank)
    missed = [told for _, truth, told, one in rows if truth > 2 * one.lod]
    unseen = sum("below LOD" in told.flags for told in missed)
    return (
        f"of {len(read)} concentrations {100 * in_68:.0f} % are within the 68 % interval and "
        f"{100 * in_95:.0f} % within the 95 % interval; of {len(below)} upper limits below LOD "
        f"{100 * held:.0f} % hold; {claimed} of {len(blank)} samples without an element are said to "
        f"have it, and {unseen} of {len(missed)} with more than twice the LOD not to"
    )


def _end(told) -> float:
    return np.inf if told.high is None else told.high


if __name__ == "__main__":
    main()
