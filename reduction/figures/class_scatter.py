"""Points in the plane of two features, coloured by class: the paper's picture of Li I against H."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..maps.classes.classify import NONE, Classes
from ..maps.points.points import Points
from .class_map import class_name
from .paper import INK, ONE_COLUMN_IN, class_colour, place

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARKERS = "osD^vP*X"
SIZE = 9.0  # points squared
FAINT_FROM = 400  # points from which on markers let others shine through
LINE_IN = 0.125


def axis_label(points: Points, element: str) -> str:
    """An element with the line that was measured, and the unit of its area."""
    line = points.line_nm.get(element)
    return f"{element} {line:.1f} nm, area (counts nm)" if line else f"{element}, area (counts nm)"


def class_scatter_figure(points: Points, classes: Classes) -> Figure:
    """The first two features of the classes; one alone is drawn against its class number."""
    from matplotlib.figure import Figure

    key = -(-len(classes) // 2) * LINE_IN + 0.1
    height = 2.55 + key
    figure = Figure(figsize=(ONE_COLUMN_IN, height))
    axes = place(figure, 0.55, 0.38, ONE_COLUMN_IN - 0.65, 2.1)
    across, up, labels = _plane(points, classes)
    alpha = 0.55 if len(points) > FAINT_FROM else 0.85
    for c in range(len(classes)):
        own = classes.label == c
        axes.scatter(
            across[own], up[own], s=SIZE, c=class_colour(c), marker=MARKERS[c % len(MARKERS)],
            linewidths=0.25, edgecolors=INK, alpha=alpha, label=class_name(classes, c),
        )  # fmt: skip
    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])
    axes.margins(0.05)
    figure.legend(
        loc="upper left", bbox_to_anchor=(0.55 / ONE_COLUMN_IN, 1 - 0.04 / height), ncols=2,
        borderaxespad=0.0, handletextpad=0.2, labelspacing=0.25,
    )  # fmt: skip
    return figure


def _plane(points: Points, classes: Classes):
    first = np.nan_to_num(points.area[classes.features[0]])
    label = axis_label(points, classes.features[0])
    if len(classes.features) > 1:
        second = np.nan_to_num(points.area[classes.features[1]])
        return first, second, (label, axis_label(points, classes.features[1]))
    return first, np.where(classes.label == NONE, np.nan, classes.label + 1.0), (label, "class")
