"""How figures look: sizes, fonts, lines and colours of a journal's page; files without a date.

Widths are those of one and two columns (85 and 178 mm). Text in PDF stays text (Type 42); in SVG it
is drawn as curves, so that it looks the same where the font is missing.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Format = Literal["png", "svg", "pdf"]
FORMATS: tuple[Format, ...] = ("png", "svg", "pdf")
ONE_COLUMN_IN, TWO_COLUMNS_IN, PAGE_IN = 3.35, 7.0, 9.2
DOTS_PER_INCH = 300  # also of the pictures inside SVG and PDF
COLOURS, HEAT = "viridis", "inferno"  # perceptually uniform, readable in grey
HOLE, QUIET, INK = "#d4d4d4", "#6b6b6b", "#1a1a1a"
# Okabe and Ito, Color Universal Design (2008), without black: told apart by the colour-blind.
CLASS_COLOURS = (
    "#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442", "#7A7A7A",
)  # fmt: skip
SMALL, NORMAL = 6.0, 7.0

STYLE = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],  # comes with matplotlib: the same on every machine
    "font.size": NORMAL,
    "mathtext.fontset": "dejavusans",
    "axes.labelsize": NORMAL,
    "axes.titlesize": NORMAL,
    "axes.linewidth": 0.6,
    "axes.edgecolor": INK,
    "axes.labelpad": 3.0,
    "axes.formatter.useoffset": False,
    "xtick.labelsize": SMALL,
    "ytick.labelsize": SMALL,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.minor.size": 1.5,
    "ytick.minor.size": 1.5,
    "xtick.major.width": 0.5,
    "ytick.major.width": 0.5,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "xtick.top": True,
    "ytick.right": True,
    "lines.linewidth": 0.8,
    "lines.markersize": 3.0,
    "legend.fontsize": SMALL,
    "legend.frameon": False,
    "legend.handlelength": 1.4,
    "errorbar.capsize": 0.0,
    "pdf.fonttype": 42,
    "svg.fonttype": "path",
    "svg.hashsalt": "labrun",
}


@contextmanager
def paper() -> Iterator[None]:
    """Draw and save within this, so that nothing of a user's own matplotlib settings leaks in."""
    quiet_matplotlib()
    import matplotlib
    from matplotlib import rc_context

    with rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(STYLE)  # pyright: ignore
        yield


def save(figure: Figure, path: Path) -> Path:
    """Write a figure in the format of the path's suffix; the same figure gives the same bytes."""
    metadata = {
        ".png": {"Software": None},
        ".svg": {"Date": None, "Creator": None},
        ".pdf": {"CreationDate": None, "ModDate": None, "Producer": None, "Creator": None},
    }[path.suffix]
    figure.savefig(path, dpi=DOTS_PER_INCH, facecolor="white", metadata=metadata)
    return path


def class_colour(label: int) -> str:
    """The colour of a class, counted from 0."""
    return CLASS_COLOURS[label % len(CLASS_COLOURS)]


def place(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Axes at a place in inches from the lower left corner."""
    across, up = figure.get_size_inches()
    return figure.add_axes((left / across, bottom / up, width / across, height / up))


def write(figure: Figure, x: float, y: float, text: str, **how) -> None:
    """Text at a place in inches from the lower left corner."""
    across, up = figure.get_size_inches()
    figure.text(x / across, y / up, text, **how)


def short(value: float) -> str:
    """A number as a label has it: three digits, thousands with a comma."""
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"


def quiet_matplotlib() -> None:
    """Import matplotlib without its remark on a home folder that it cannot keep its font list in."""
    log = logging.getLogger("matplotlib")
    level = log.level
    log.setLevel(logging.ERROR)
    try:
        import matplotlib.font_manager  # noqa: F401
    finally:
        log.setLevel(level)
