"""Draw the element maps of a run, and the charts of its check standards, from the rows that it collected."""

import csv
from pathlib import Path
from typing import TYPE_CHECKING

from ..lines.symbols import BY_NUMBER, SYMBOLS
from ..spectrum.fault import Unreadable

if TYPE_CHECKING:
    from ..maps.points.points import Points

ROWS = "data*.csv"
STANDARD = "standard"  # a column of check standards
CHART = "checks.png"
LEAST_OF_A_LINE = 3  # points below which a line is not worth a figure


def make(folder: Path) -> list[Path]:
    """Draw the maps of the run in `folder`; returns the files written, none if there is nothing to map.

    Reads `data.csv` (and `data-NAME.csv`): coordinates are the columns `x` and `y`, or `x_mm` and
    `y_mm` with their unit; elements are the columns named by a chemical symbol, `Li_wt_percent` and the
    like are concentrations. Empty cells are holes. An area becomes `element_maps.png`, a line
    `line_scan.png`, and `concentrations.png` either, with the sample's name if there are several;
    check standards become `checks.csv` and `checks.png`.
    Raises OSError if a figure cannot be written.
    """
    # Most runs have no elements, and what draws these need not be installed for them.
    if not any(_tells_elements(path) for path in folder.glob(ROWS)):
        return []
    return [*_maps(folder), *_checks(folder)]


def _tells_elements(path: Path) -> bool:
    """Whether a column is an element, something of one (`Li_wt_percent`), or names a check standard."""
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
        names = [name.strip() for name in next(csv.reader(file), [])]
    return STANDARD in names or any(name.partition("_")[0] in SYMBOLS for name in names)


def _checks(folder: Path) -> list[Path]:
    """What the run's check standards read, as a table of verdicts and as charts; nothing without."""
    from ..maps.checks import read_checks
    from .tables import write_checks

    checks = read_checks(folder)
    if not checks:
        return []
    from ..figures.control_chart import control_chart
    from ..figures.paper import paper, save

    with paper():
        return [write_checks(checks, folder), save(control_chart(checks), folder / CHART)]


def _maps(folder: Path) -> list[Path]:
    import numpy as np

    from ..maps.points.gather import gather

    try:
        points = gather(folder, tables=False)
    except Unreadable:
        return []
    there = [name for name, area in points.area.items() if np.isfinite(area).any()]
    elements = sorted(there, key=BY_NUMBER.split().index)  # pyright: ignore
    if not (elements or points.contents) or not _worth_it(points):
        return []
    from ..figures.paper import paper, save
    from .choices import MapChoices
    from .sample_figures import sample_figures

    title = folder.resolve().name
    with paper():
        return [
            save(draw(), folder / f"{name}.png")
            for name, draw in sample_figures(points, elements, None, MapChoices(), title)
        ]


def _worth_it(points: "Points") -> bool:
    """Whether there is an area, or a line of some length."""
    from ..maps.scattered import along_line

    placed = points.placed
    if placed.sum() < 2:
        return False
    line = along_line(points.x[placed], points.y[placed]) is not None
    return not line or int(placed.sum()) >= LEAST_OF_A_LINE
