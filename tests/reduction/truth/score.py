"""How near a reduction comes to the truth.

Peaks. A true peak is a maximum of the noise-free line light that stands at least 5 sigma of its
channel's noise above its valleys. Recall: those with a found peak within 0.05 nm. Precision: found
peaks that have, within 0.05 nm, a maximum of 2 sigma or a line of 2.5 sigma (a real line, though
hidden on a flank), each used once. Lines: the harder question, recall of every group of lines of
5 sigma by its own height that has half the light in its middle, resolved or not.
Elements. Claims of doubtful elements (see spectra) count neither way.
Area. Groups that stand alone, 10 sigma high, not saturated: median of |found / true - 1|.
Pulls. (found - true) / error over the same groups; their robust spread should be 1.
"""

from dataclasses import dataclass, field

import numpy as np

from .spectra import Truth

WITHIN_NM = 0.05


@dataclass
class Score:
    """Counts and lists of one spectrum, or, added up, of many."""

    true_peaks: int = 0
    recalled: int = 0
    found_peaks: int = 0
    right: int = 0
    true_lines: int = 0
    recalled_lines: int = 0
    hits: int = 0
    false_claims: int = 0
    missed: int = 0
    area_error: list[float] = field(default_factory=list)
    strong_area_error: list[float] = field(default_factory=list)
    pull: list[float] = field(default_factory=list)
    centre_pull: list[float] = field(default_factory=list)
    kelvin_error: list[float] = field(default_factory=list)
    kelvin_pull: list[float] = field(default_factory=list)
    log_ne_error: list[float] = field(default_factory=list)
    lithium_pull: list[float] = field(default_factory=list)
    medium_right: int = 0
    spectra: int = 0
    wrong_elements: list[str] = field(default_factory=list)
    missed_elements: list[str] = field(default_factory=list)

    def add(self, other: "Score") -> None:
        for name, value in vars(other).items():
            setattr(self, name, getattr(self, name) + value)


def pairs(found: np.ndarray, true: np.ndarray, within: float) -> list[tuple[int, int]]:
    """One-to-one pairs (found, true), nearest first."""
    close = [
        (abs(found[i] - true[j]), i, j)
        for i in range(len(found))
        for j in np.flatnonzero(np.abs(true - found[i]) <= within)
    ]
    used_found, used_true, chosen = set(), set(), []
    for _, i, j in sorted(close):
        if i not in used_found and j not in used_true:
            used_found.add(i)
            used_true.add(j)
            chosen.append((i, int(j)))
    return chosen


def score(
    truth: Truth,
    centre_nm: np.ndarray,
    centre_error: np.ndarray,
    area: np.ndarray,
    area_error: np.ndarray,
    claimed: set[str],
    kelvin: tuple[float, float] | None,
    log10_ne: float | None,
    medium: str,
    lithium: tuple[float, float, tuple[str, ...]] | None = None,
) -> Score:
    """The score of one spectrum. centre_nm: found peaks (those said to be of 5 sigma) as shown.
    lithium: its share of the atoms of some elements, with its error, and which they are."""
    s = Score(spectra=1, medium_right=int(medium == truth.instrument.medium))
    _peaks(s, truth, centre_nm)
    _areas(s, truth, centre_nm, centre_error, area, area_error)
    wrong = claimed - truth.present - truth.doubtful
    gone = truth.present - claimed
    s.hits, s.false_claims, s.missed = len(claimed & truth.present), len(wrong), len(gone)
    s.wrong_elements = [f"{truth.name}:{e}" for e in sorted(wrong)]
    s.missed_elements = [f"{truth.name}:{e}" for e in sorted(gone)]
    if kelvin is not None:
        s.kelvin_error.append(kelvin[0] / truth.kelvin - 1)
        s.kelvin_pull.append((kelvin[0] - truth.kelvin) / kelvin[1])
    if log10_ne is not None and truth.h_alpha:
        s.log_ne_error.append(log10_ne - truth.log10_ne)
    if lithium is not None and "Li" in truth.shares:
        share, error, counted = lithium
        true = truth.shares["Li"] / sum(truth.shares.get(element, 0.0) for element in counted)
        s.lithium_pull.append((share - true) / error)
    return s


def _peaks(s: Score, truth: Truth, centre_nm: np.ndarray) -> None:
    g = truth.groups
    true = truth.maxima_nm[truth.maxima_sigma >= 5]
    s.true_peaks, s.recalled = len(true), len(pairs(centre_nm, true, WITHIN_NM))
    fair = g.shown_nm[g.height > 2.5 * g.noise] if len(g.shown_nm) else np.empty(0)
    real = np.concatenate([truth.maxima_nm[truth.maxima_sigma >= 2], fair])
    s.found_peaks = len(centre_nm)
    s.right = len({i for i, _ in pairs(centre_nm, real, WITHIN_NM)})
    if len(g.shown_nm):
        lines = g.shown_nm[(g.height > 5 * g.noise) & (g.height > 0.5 * g.light)]
        s.true_lines, s.recalled_lines = len(lines), len(pairs(centre_nm, lines, WITHIN_NM))


def _areas(s, truth, centre_nm, centre_error, area, area_error) -> None:
    g = truth.groups
    if not len(g.shown_nm):
        return
    near_bad = np.array(
        [
            bool(
                np.any(truth.bad[slice(*np.searchsorted(truth.wavelength_nm, [x - 0.5, x + 0.5]))])
            )
            for x in g.shown_nm
        ]
    )
    chosen = np.flatnonzero(g.alone & (g.height > 10 * g.noise) & ~near_bad)
    for i, j in pairs(centre_nm, g.shown_nm[chosen], 0.1):
        k = chosen[j]
        s.area_error.append(abs(area[i] / g.area[k] - 1))
        if g.height[k] > 30 * g.noise[k]:
            s.strong_area_error.append(s.area_error[-1])
        s.pull.append((area[i] - g.area[k]) / area_error[i])
        s.centre_pull.append((centre_nm[i] - g.shown_nm[k]) / centre_error[i])


def spread(values: list[float]) -> float:
    """Standard deviation as the median tells it."""
    return float(1.4826 * np.median(np.abs(np.array(values)))) if values else float("nan")


def within(pulls: list[float], errors: float) -> float:
    """The part of the pulls that is no larger than so many errors."""
    return float(np.mean(np.abs(pulls) <= errors)) if pulls else float("nan")


def summary(s: Score) -> dict[str, float]:
    """The figures of the accuracy table."""

    def part(a: float, b: float) -> float:
        return a / b if b else float("nan")

    def median(values: list[float]) -> float:
        return float(np.median(np.abs(values))) if values else float("nan")

    return {
        "peaks recall": part(s.recalled, s.true_peaks),
        "peaks precision": part(s.right, s.found_peaks),
        "lines recall": part(s.recalled_lines, s.true_lines),
        "elements F1": part(2 * s.hits, 2 * s.hits + s.false_claims + s.missed),
        "area error": median(s.area_error),
        "area error, 30 sigma": median(s.strong_area_error),
        "area pull": spread(s.pull),
        "centre pull": spread(s.centre_pull),
        "T error": median(s.kelvin_error),
        "T pull": spread(s.kelvin_pull),
        "T known": part(len(s.kelvin_error), s.spectra),
        "log ne error": median(s.log_ne_error),
        "T within 1": within(s.kelvin_pull, 1.0),
        "T within 2": within(s.kelvin_pull, 2.0),
        "Li within 1": within(s.lithium_pull, 1.0),
        "Li within 2": within(s.lithium_pull, 2.0),
        "medium right": part(s.medium_right, s.spectra),
    }
