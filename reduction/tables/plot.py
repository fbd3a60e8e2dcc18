"""The Saha-Boltzmann plot of a reduction: its lines, and what they say of lithium."""

from ..plasma.boltzmann import Bend, Plot, PlotLines
from ..plasma.lithium_share import LithiumShare, ShareCurve, lithium_share, share_curve
from ..reduce import Reduction


def lines_of_plot(reduction: Reduction) -> PlotLines | None:
    """The lines that the plasma's plot was fitted to; None where there was no plot."""
    found = reduction.identified
    if found is None or found.plot is None:
        return None
    return found.lines


def cation_fraction(reduction: Reduction) -> LithiumShare | None:
    """Lithium's fraction of the cations, by atoms; None where the plot has no line of lithium.

    The one definition: in the tables, the maps and the figures. Chamber gas, air and anions do not
    count; the light that lines lose to self-absorption is made good.
    """
    plotted = _plotted(reduction)
    return None if plotted is None else lithium_share(*plotted)


def fraction_curve(reduction: Reduction) -> ShareCurve | None:
    """The same at other temperatures, for figures; None where there was no plot."""
    plotted = _plotted(reduction)
    return None if plotted is None else share_curve(*plotted)


def _plotted(reduction: Reduction) -> tuple[PlotLines, Plot, Bend] | None:
    found = reduction.identified
    if found is None or found.lines is None or found.plot is None or found.bend is None:
        return None
    return found.lines, found.plot, found.bend
