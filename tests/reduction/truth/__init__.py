"""Spectra with a known truth, made without any code of the package under test.

What it shares with `labrun.reduction` is data alone: the table of lines and levels. Partition
sums, Saha and Boltzmann, the air's index, line shapes, transfer of light, detectors and their
faults are written here once more, and in other ways.
"""

from .everyday import KINDS, everyday
from .score import Score, score, summary
from .spectra import FAMILIES, Truth, line_free, make_spectrum, pure_noise
from .vices import VICES, with_vice

__all__ = [
    "FAMILIES",
    "KINDS",
    "VICES",
    "Score",
    "Truth",
    "everyday",
    "line_free",
    "make_spectrum",
    "pure_noise",
    "score",
    "summary",
    "with_vice",
]
