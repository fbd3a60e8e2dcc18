"""Draw the results of one reduced spectrum: line names, a fit, the plasma's plot, lithium."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from ..reduce import Reduction
from ..spectrum.spectrum import Spectrum
from ..tables.plot import cation_fraction, fraction_curve, lines_of_plot
from .boltzmann import boltzmann_figure
from .fit_window import fit_figure, window_around
from .lithium_ratio import lithium_ratio_figure
from .lithium_share import lithium_share_figure
from .paper import Format, paper, save
from .series import Series
from .spectrum import spectrum_figure

LITHIUM_NM = 670.8


def draw_spectrum(
    spectrum: Spectrum, reduction: Reduction, folder: Path, name: str,
    window_nm: tuple[float, float] | None = None, log: bool = False, format: Format = "png",
) -> list[Path]:  # fmt: skip
    """The figures that were written into `folder`, each named after the spectrum.

    window_nm: the stretch whose fit is shown; around lithium's red line, else around the clearest
    peak, if None. Raises ValueError for a window without channels, OSError where a file is refused.
    """
    if window_nm is None:
        lithium = "Li" in reduction.detected
        window_nm = window_around(reduction, LITHIUM_NM if lithium else None)
    with paper():
        return [
            save(draw(), folder / f"{name}_{kind}.{format}")
            for kind, draw in _figures(reduction, window_nm, log)
        ]


def _figures(reduction: Reduction, window_nm, log) -> Iterator[tuple[str, Callable]]:
    if len(reduction.peaks):
        yield "fit", lambda: fit_figure(reduction, window_nm)
    yield "spectrum", lambda: spectrum_figure(reduction, log)
    if lines_of_plot(reduction) is not None:
        yield "boltzmann", lambda: boltzmann_figure(reduction)
    plasma = reduction.plasma
    if plasma is None or plasma.temperature_k is None:
        return
    kelvin = _one(plasma.temperature_k, plasma.temperature_error_k)
    if plasma.lithium is not None and plasma.method != "lithium ratio":
        ratio = _one(plasma.lithium.ratio, plasma.lithium.ratio_error)
        yield "lithium_ratio", lambda: lithium_ratio_figure(kelvin, ratio)
    share = cation_fraction(reduction)
    if share is not None:
        found, curve = _one(share.share, share.share_error), fraction_curve(reduction)
        yield (
            "lithium_fraction",
            lambda: lithium_share_figure(kelvin, found, None, curve, share.elements),
        )


def _one(value: float, error: float | None) -> Series:
    return Series(np.array([value]), np.array([np.nan if error is None else error]))
