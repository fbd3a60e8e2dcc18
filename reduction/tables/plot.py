"""The Saha-Boltzmann plot of a reduction: its lines, and what they say of lithium."""

from ..plasma.boltzmann import PlotLines
from ..plasma.lithium_share import LithiumShare, lithium_share
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
    lines, found = lines_of_plot(reduction), reduction.identified
    if lines is None or found is None or found.plot is None:
        return None
    return lithium_share(lines, found.plot)
