"""How much of a full map a part of its shots gives: a regular grid, or chosen by the driver `gp`.

The simulated analyser fires at 21 x 51 places, 0.2 mm apart, on cores of several seeds, and the
reduction gives the areas of Li, K and Si. A map of fewer shots is drawn on the same 1071 places and
correlated with the share of the element's atoms that the crater truly had; the figure is the mean of
the three elements. Left out are the engine, the gantry's steps (0.005 mm) and failed shots.

    python benchmarks/adaptive.py --keep /tmp/cores --cores 10 --draw adaptive.png
"""

import argparse
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from scipy.interpolate import griddata

from labrun.drivers.driver import Place
from labrun.drivers.optimizer.gp import Gp
from labrun.drivers.optimizer.problem import read_problem
from labrun.drivers.optimizer.study import Study
from labrun.drivers.simulated.twins.minerals import ELEMENTS
from labrun.drivers.simulated.twins.shot import ShotMaker
from labrun.reduction import reduce_spectrum
from labrun.reduction.spectrum.spectrum import Spectrum

WANTED = ("Li", "K", "Si")
COLUMNS, ROWS, PITCH_MM = 21, 51, 0.2
QUARTER = 268
COUNTS = (134, 200, QUARTER, 334, 400, 468, 536)
BATCH = 16
FIRST_SEED = 11

GRID = np.array([(column, row) for row in range(ROWS) for column in range(COLUMNS)])
ORIGIN_MM = np.array([0.0, 3.0])
PLACES_MM = GRID * PITCH_MM


def shots(core: int, places_mm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Areas measured and true atom shares at the places, one row each and one column an element."""
    maker = ShotMaker(core, 1)
    areas, shares = [], []
    for n, (x, y) in enumerate(np.round(places_mm + ORIGIN_MM, 4).tolist(), 1):
        focus = np.exp(-(maker.surface(x, y)[1] ** 2) / 2)
        counts = maker.counts({"n": n, "focus": round(float(focus), 5), "x": x, "y": y})
        found = reduce_spectrum(Spectrum(maker.plasma.axis, counts.astype(float)), WANTED).to_dict()
        areas.append([found["areas"].get(element, 0.0) for element in WANTED])
        truly = maker.core.composition_in_crater(x, y)
        shares.append([truly[ELEMENTS.index(element)] for element in WANTED])
    return np.array(areas), np.array(shares)


def correlation(drawn: np.ndarray, truth: np.ndarray) -> float:
    """Mean over the elements of Pearson's coefficient."""
    return float(np.mean([np.corrcoef(a, b)[0, 1] for a, b in zip(drawn.T, truth.T, strict=True)]))


def between(at_mm: np.ndarray, areas: np.ndarray, how: str) -> np.ndarray:
    """A map of all places from those measured, nearest or linear (nearest beyond the outermost)."""
    drawn = griddata(at_mm, areas, PLACES_MM, method=how)
    nearest = griddata(at_mm, areas, PLACES_MM, method="nearest")
    return np.where(np.isnan(drawn), nearest, drawn)


def regular_grids() -> Iterator[tuple[str, np.ndarray]]:
    """Regular grids of up to QUARTER places: rows and columns, and every skewed one of the fine grid."""
    width, height = (COLUMNS - 1) * PITCH_MM, (ROWS - 1) * PITCH_MM
    for columns in range(10, 12):
        rows = QUARTER // columns
        x, y = np.linspace(0, width, columns), np.linspace(0, height, rows)
        yield f"{columns} x {rows}", np.array([(a, b) for b in y for a in x])
    column, row = GRID.T
    for skew in range(4):
        for first in range(4):
            for name, line in (
                (f"x + {skew} y", column + skew * row),
                (f"{skew} x + y", skew * column + row),
            ):
                at = np.flatnonzero(line % 4 == first)
                if len(at) <= QUARTER:
                    yield f"{name} = {first} (mod 4)", PLACES_MM[at]


def chosen(areas: np.ndarray) -> Iterator[tuple[int, np.ndarray, float]]:
    """Shots, the map of the driver's own model, and seconds an ask, whenever a count is reached."""
    space = {
        "x": {"minimum": 0, "maximum": (COLUMNS - 1) * PITCH_MM, "step": PITCH_MM},
        "y": {"minimum": 0, "maximum": (ROWS - 1) * PITCH_MM, "step": PITCH_MM},
    }
    study = Study("map", read_problem({"space": space, "goals": dict.fromkeys(WANTED, "map")}))
    gp = Gp(Place("optimizer", {}, {}, Path(), Path()))
    everywhere = [{"x": x, "y": y} for x, y in PLACES_MM.tolist()]
    while study.told < max(COUNTS):
        at = time.perf_counter()
        points = gp.suggest(
            study, min(BATCH, next(n for n in COUNTS if n > study.told) - study.told)
        )
        took_s = time.perf_counter() - at
        study.suggested(points)
        for point in points:
            place = round(point["y"] / PITCH_MM) * COLUMNS + round(point["x"] / PITCH_MM)
            study.tell(point, dict(zip(WANTED, areas[place].tolist(), strict=True)))
        if study.told in COUNTS:
            mean, _ = gp.predict(study, everywhere)
            yield study.told, np.array([mean[element] for element in WANTED]).T, took_s


def of_core(core: int, keep: Path | None) -> dict[str, np.ndarray]:
    """Everything that is shot on one core; from the folder if it was shot before."""
    path = keep / f"core_{core}.npz" if keep else None
    if path is not None and path.exists():
        return dict(np.load(path))
    areas, shares = shots(core, PLACES_MM)
    kept = {"areas": areas, "shares": shares}
    for name, at_mm in regular_grids():
        if "mod" not in name:
            kept[name] = shots(core, at_mm)[0]
    if path is not None:
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savez(path, allow_pickle=False, **kept)
    return kept


def main() -> None:
    """Shoot, choose, print the table, draw the curves."""
    words = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    words.add_argument("--cores", type=int, default=10)
    words.add_argument("--keep", type=Path, help="folder for what was shot, read again next time")
    words.add_argument("--draw", type=Path, help="PNG of both curves")
    asked = words.parse_args()
    full, took = [], []
    regular: dict[str, list[float]] = {}
    adaptive: dict[int, list[float]] = {count: [] for count in COUNTS}
    for core in range(FIRST_SEED, FIRST_SEED + asked.cores):
        kept = of_core(core, asked.keep)
        truth = kept["shares"]
        full.append(correlation(kept["areas"], truth))
        places = {tuple(row): n for n, row in enumerate(PLACES_MM.tolist())}
        for name, at_mm in regular_grids():
            areas = kept.get(name)
            if areas is None:
                areas = kept["areas"][[places[tuple(row)] for row in at_mm.tolist()]]
            for how in ("nearest", "linear"):
                drawn = between(at_mm, areas, how)
                regular.setdefault(f"{name}, {how}", []).append(correlation(drawn, truth))
        for count, drawn, took_s in chosen(kept["areas"]):
            adaptive[count].append(correlation(drawn, truth))
            took.append(took_s)
        line = ", ".join(f"{count}: {adaptive[count][-1]:.3f}" for count in COUNTS)
        print(f"core {core}: full grid {full[-1]:.3f}; adaptive {line}", flush=True)
    best = max(regular, key=lambda name: float(np.mean(regular[name])))
    print(f"\nmean of {asked.cores} cores (standard error), {COLUMNS * ROWS} places")
    print(f"full grid of {COLUMNS * ROWS}: {_figure(full)}")
    print(
        f"best of {len(regular)} regular maps of up to {QUARTER} ({best}): {_figure(regular[best])}"
    )
    for count in COUNTS:
        part = np.mean(adaptive[count]) / np.mean(full)
        print(f"adaptive, {count}: {_figure(adaptive[count])}, {part:.3f} of the full grid's")
    gain = np.array(adaptive[QUARTER]) - np.array(regular[best])
    print(f"adaptive over regular at {QUARTER}: {_figure(gain)}")
    print(f"an ask of up to {BATCH} took {np.median(took):.2f} s, at most {max(took):.2f} s")
    if asked.draw is not None:
        draw(asked.draw, full, regular[best], adaptive)


def _figure(values: object) -> str:
    each = np.asarray(values, float)
    return f"{each.mean():.3f} ({each.std(ddof=1) / np.sqrt(len(each)):.3f})"


def draw(
    path: Path, full: list[float], regular: list[float], adaptive: dict[int, list[float]]
) -> None:
    """Both curves over the number of shots."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
    axes.errorbar(
        list(adaptive), [np.mean(v) for v in adaptive.values()], [np.std(v) for v in adaptive.values()],
        fmt="o-", label="chosen by gp",
    )  # fmt: skip
    axes.errorbar(
        [QUARTER, COLUMNS * ROWS], [np.mean(regular), np.mean(full)], [np.std(regular), np.std(full)],
        fmt="s--", label="regular grid",
    )  # fmt: skip
    axes.set(xlabel="shots", ylabel="correlation with the truth (mean of Li, K, Si)")
    axes.legend()
    figure.savefig(path, dpi=150)


if __name__ == "__main__":
    main()
