"""The row of `plasma`: a spectrum's temperature and electron density, empty if undetermined."""

from ..reduce import Reduction
from .columns import BETWEEN_FLAGS, Cells
from .plot import cation_fraction

NO_EQUILIBRIUM = "too few electrons for equilibrium (McWhirter)"


def plasma_row(reduction: Reduction) -> Cells:
    """One row, with whatever is known."""
    plasma, lithium = reduction.plasma, cation_fraction(reduction)
    share = {
        "li_cation_fraction": [None if lithium is None else lithium.share],
        "li_cation_fraction_err": [None if lithium is None else lithium.share_error],
        "li_cation_fraction_low": [None if lithium is None else lithium.low],
        "li_cation_fraction_high": [None if lithium is None else lithium.high],
    }
    if plasma is None:
        return {
            "temperature_k": [None], "temperature_err": [None], "log10_ne": [None],
            "log10_ne_err": [None], **share, "method": [""], "flags": [""],
        }  # fmt: skip
    doubts = (NO_EQUILIBRIUM,) if plasma.mcwhirter is False else ()
    return {
        "temperature_k": [plasma.temperature_k],
        "temperature_err": [plasma.temperature_error_k],
        "log10_ne": [plasma.log10_ne],
        "log10_ne_err": [plasma.log10_ne_error],
        **share,
        "method": [plasma.method],
        "flags": [BETWEEN_FLAGS.join((*plasma.flags, *doubts))],
    }
