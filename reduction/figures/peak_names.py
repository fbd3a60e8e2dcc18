"""Name the line of each peak of a reduction, in spectroscopic notation: 'Li I 670.8'."""

from ..reduce import Reduction
from ..tables.named import names


def peak_names(reduction: Reduction) -> list[str]:
    """A name for each peak, '' if no found element explains it."""
    named, centres = names(reduction), reduction.peaks.centre_nm
    return [
        f"{element} {'I' * stage} {nm:.1f}" if element else ""
        for element, stage, nm in zip(named.element, named.stage, centres, strict=True)
    ]
