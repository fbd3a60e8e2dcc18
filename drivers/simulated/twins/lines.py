"""The shapes of spectral lines on the spectrometer's channels.

Most lines are thin: their shapes are made once, and a spectrum is a weighted sum of them. A
hundred strong ones change shape from shot to shot, since they widen with the electrons and
absorb their own light, so their shapes are computed again each time.
"""

import numpy as np

from . import instrument
from .atoms import Lines

FINE = 8  # places a channel at which light is reckoned before the slit blurs it
MARGIN = 6  # channels beyond which the slit reaches no more
NARROW = 24  # channels that a thin line reaches to either side
CORE = 12  # channels around a strong line's centre that the slit changes
WINGS = 120  # channels that a strong line's wings reach
SHARPEST_NM = 0.012  # Doppler and van der Waals leave nothing narrower


class WeakLines:
    """Lines that shine through each other and keep their shape."""

    def __init__(self, lines: Lines) -> None:
        self.lines = lines
        middle, offset = _middles(lines)
        edges, places, channels = _fine(NARROW)
        half = np.maximum(lines.stark_nm, SHARPEST_NM) / 2 / instrument.CHANNEL_NM
        whole = np.arctan((edges - offset[:, None]) / half[:, None]) / np.pi
        step = places[1] - places[0]
        # Each interval holds exactly its part of the Lorentz profile, however narrow that is.
        shapes = np.diff(whole, axis=1) / step @ instrument.blur(places, channels)
        self.shapes = shapes / instrument.CHANNEL_NM
        self.onto = _Onto(middle, channels)

    def shine(self, energy: np.ndarray) -> np.ndarray:
        """The spectrum of lines of so much energy (counts nm)."""
        return self.onto.add(self.shapes * energy[:, None])


class StrongLines:
    """Lines that absorb their own light: where it is t deep, (1 - exp(-t)) / t of it is left."""

    def __init__(self, lines: Lines) -> None:
        self.lines = lines
        middle, offset = _middles(lines)
        _, places, core = _fine(CORE)
        channels = np.arange(-WINGS, WINGS + 1)
        self.far_nm = (channels - offset[:, None]) * instrument.CHANNEL_NM
        self.near_nm = (places - offset[:, None]) * instrument.CHANNEL_NM
        self.blur = instrument.blur(places, core)
        self.onto = _Onto(middle, channels)

    def shine(self, energy: np.ndarray, depth: np.ndarray, width_nm: np.ndarray) -> np.ndarray:
        """The spectrum of lines of such energy (counts nm), depth (times nm) and full width."""
        width_nm = np.maximum(width_nm, SHARPEST_NM)
        figures = energy[:, None], depth[:, None], width_nm[:, None] / 2
        shapes = _slab(self.far_nm, *figures)
        shapes[:, WINGS - CORE : WINGS + CORE + 1] = _slab(self.near_nm, *figures) @ self.blur
        return self.onto.add(shapes)


class _Onto:
    """Adds windows of channels around many lines onto one spectrum."""

    def __init__(self, middle: np.ndarray, channels: np.ndarray) -> None:
        place = middle[:, None] + channels
        # What falls beside the detector is gathered in one more channel, and dropped.
        outside = (place < 0) | (place >= instrument.CHANNELS)
        self.place = np.where(outside, instrument.CHANNELS, place).ravel()

    def add(self, shapes: np.ndarray) -> np.ndarray:
        size = instrument.CHANNELS
        return np.bincount(self.place, weights=shapes.ravel(), minlength=size + 1)[:size]


def _middles(lines: Lines) -> tuple[np.ndarray, np.ndarray]:
    """The channel nearest to each line, and how far from its middle the line is, in channels."""
    place = (instrument.shown_at(lines.wavelength_nm) - instrument.FIRST_NM) / instrument.CHANNEL_NM
    middle = np.round(place).astype(int)
    return middle, place - middle


def _fine(reach: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Edges and middles of fine intervals around a channel, and the channels within `reach`."""
    edges = np.linspace(-reach - MARGIN, reach + MARGIN, 2 * (reach + MARGIN) * FINE + 1)
    return edges, (edges[1:] + edges[:-1]) / 2, np.arange(-reach, reach + 1)


def _slab(
    away_nm: np.ndarray, energy: np.ndarray, depth: np.ndarray, half_nm: np.ndarray
) -> np.ndarray:
    profile = half_nm / np.pi / (away_nm**2 + half_nm**2)
    opacity = depth * profile + 1e-9  # the limit of a clear slab needs no branch
    return energy * profile * -np.expm1(-opacity) / opacity
