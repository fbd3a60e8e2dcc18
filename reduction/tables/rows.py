"""All rows of one spectrum, packed for the way to whoever writes them."""

from collections.abc import Sequence

from ..reduce import Reduction
from ..spectrum import Spectrum
from .arrow import batch_of, packed
from .element_rows import element_rows
from .file_rows import file_row
from .peak_rows import peak_rows
from .plasma_rows import plasma_row


def rows_of(
    name: str, spectrum: Spectrum, reduction: Reduction, only: Sequence[str] | None = None
) -> dict[str, bytes]:
    """The packed rows by table. name: of the spectrum; only: elements that get a row, all if None."""
    x = spectrum.wavelength_nm
    cells = {
        "files": file_row(spectrum, reduction),
        "peaks": peak_rows(x, reduction),
        "elements": element_rows(x, reduction, only),
        "plasma": plasma_row(reduction),
    }
    return {table: packed(batch_of(table, name, said)) for table, said in cells.items()}
