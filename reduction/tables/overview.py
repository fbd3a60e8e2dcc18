"""One figure for a whole batch: its elements, temperatures and numbers of lines."""

from __future__ import annotations

from collections import Counter
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pyarrow.parquet as pq

from ...system.files import write_whole
from ..spectrum.spectrum import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAME = "overview.png"
LEAST_SPECTRA = 5  # too few for a distribution below this
MOST_ELEMENTS = 16
DETECTED, UNCERTAIN, INK = "#2f6f8f", "#b9d3df", "#3a3a3a"
DOTS_PER_INCH = 160
MARGINS = {"left": 0.04, "right": 0.99, "bottom": 0.13, "top": 0.85, "wspace": 0.27}


def draw_overview(folder: Path, reduced: int) -> Path | None:
    """Draw it from the tables in `folder`, beside them; None if there are too few spectra.

    reduced: number of reduced spectra. Raises OSError if it cannot be written.
    """
    if reduced < LEAST_SPECTRA:
        return None
    drawn = BytesIO()
    _figure(folder, reduced).savefig(drawn, dpi=DOTS_PER_INCH, facecolor="white", format="png")
    write_whole(folder / NAME, drawn.getvalue(), sync=False)
    return folder / NAME


def _figure(folder: Path, reduced: int) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.5, 4.2))  # automatic layout takes twice as long
    left, *others = figure.subplots(1, 4, width_ratios=(1.5, 1, 1, 1), gridspec_kw=MARGINS)
    _elements(left, folder, reduced)
    plasma = pq.read_table(folder / "plasma.parquet", columns=["temperature_k", "log10_ne"])
    files = pq.read_table(folder / "files.parquet", columns=["n_peaks"])
    _spread(others[0], _numbers(plasma["temperature_k"]) / 1e3, "temperature (10³ K)", "{:.1f}")
    _spread(others[1], _numbers(plasma["log10_ne"]), "log₁₀ electrons per cm³", "{:.2f}")
    _spread(others[2], _numbers(files["n_peaks"]), "peaks in a spectrum", "{:.0f}")
    others[0].set_ylabel("spectra", fontsize=9)
    figure.suptitle(f"{reduced:,} spectra", fontsize=11, fontweight="bold")
    return figure


def _numbers(column) -> FloatArray:
    return column.drop_null().to_numpy().astype(np.float64)


def _elements(panel: Axes, folder: Path, reduced: int) -> None:
    rows = pq.read_table(folder / "elements.parquet", columns=["element", "status"])
    sure, unsure = (
        Counter(rows["element"].filter(_is(rows["status"], status)).to_pylist())
        for status in ("detected", "uncertain")
    )
    names = sorted({*sure, *unsure}, key=lambda n: (-sure[n], -unsure[n], n))[:MOST_ELEMENTS]
    part = 100.0 / reduced
    first = np.array([sure[name] * part for name in names])
    second = np.array([unsure[name] * part for name in names])
    panel.barh(names, first, color=DETECTED, label="detected", height=0.72)
    panel.barh(names, second, left=first, color=UNCERTAIN, label="uncertain", height=0.72)
    panel.invert_yaxis()
    panel.set_xlim(0, 100)
    panel.set_xlabel("per cent of the spectra", fontsize=9)
    if names:
        panel.legend(frameon=False, fontsize=8, loc="lower right")
    _dress(panel)


def _is(column, status: str):
    return np.array([value == status for value in column.to_pylist()])


def _spread(panel: Axes, values: FloatArray, label: str, words: str) -> None:
    panel.set_xlabel(label, fontsize=9)
    _dress(panel)
    if not len(values):
        panel.text(0.5, 0.5, "not told", transform=panel.transAxes, ha="center", color=INK)
        panel.set_yticks([])
        return
    low, middle, high = np.percentile(values, [0.5, 50, 99.5])
    panel.hist(values, bins=30, range=(low, high) if high > low else None, color=DETECTED)
    panel.axvline(middle, color=INK, linewidth=1)
    panel.set_title(f"median {words.format(middle)}", fontsize=9, color=INK)


def _dress(panel: Axes) -> None:
    panel.tick_params(labelsize=8, length=2.5, width=0.6)
    panel.spines[["top", "right"]].set_visible(False)
    for spine in panel.spines.values():
        spine.set_linewidth(0.6)
