"""A spectrum as a small picture that a browser draws: how it shows itself in a notebook."""

import html
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .spectrum import Spectrum

WIDTH, HEIGHT, EDGE = 720, 200, 24
"""Pixels; the edge below has the wavelengths."""


def as_svg(spectrum: "Spectrum") -> str:
    """Its range and outline: of the channels that share a column of pixels, the least and the most.

    A bad channel is a gap, so that nobody takes it for a value.
    """
    nm, counts = spectrum.wavelength_nm, spectrum.intensity
    low, high = nm[0], nm[-1]
    good = counts[np.isfinite(counts)]
    if not good.size:
        return "<p>a spectrum without a good channel</p>"
    least, most = min(good.min(), 0.0), good.max()
    x = (nm - low) / ((high - low) or 1.0) * WIDTH
    y = HEIGHT - (counts - least) / ((most - least) or 1.0) * HEIGHT
    path = "".join(_strokes(x, y))
    words = f"{nm.size:,} channels, {low:.2f} to {high:.2f} nm, at most {most:.6g} counts"
    notes = "".join(f"<li>{html.escape(note)}</li>" for note in spectrum.notes)
    return (
        f"<svg viewBox='0 0 {WIDTH} {HEIGHT + EDGE}' width='{WIDTH}' role='img' aria-label='{words}' "
        f"style='max-width:100%'><path d='{path}' fill='none' stroke='#3b6ea5'/>"
        f"<g font-size='12' fill='currentColor'><text y='{HEIGHT + 16}'>{low:.1f} nm</text>"
        f"<text x='{WIDTH}' y='{HEIGHT + 16}' text-anchor='end'>{high:.1f} nm</text></g></svg>"
        f"<p>{words}</p>" + (f"<ul>{notes}</ul>" if notes else "")
    )


def _strokes(x: np.ndarray, y: np.ndarray) -> "list[str]":
    """Commands of an SVG path: at most a stroke down and one on for each column of pixels."""
    said, pen_is_down = [], False
    edges = np.flatnonzero(np.diff(x.astype(int), prepend=-1))
    for here, column in zip(x[edges], np.split(y, edges[1:]), strict=True):
        if not np.isfinite(column).all():
            pen_is_down = False
        column = column[np.isfinite(column)]
        if column.size:
            said.append(f"{'L' if pen_is_down else 'M'}{here:.1f} {column.max():.1f}")
            said.append(f"V{column.min():.1f}" if column.size > 1 else "")
            pen_is_down = True
    return said
