"""What a file says of a spectrum, before it is judged: an axis, counts, and what was noticed."""

from dataclasses import dataclass

from .axis import Unit
from .spectrum import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Readout:
    """axis: shape (n,), in `unit`, None where the file does not say it. shots: shape (k, n), counts.

    notes: sentences for the reader of the tables. wavelengths: whether the file says that these are the axis.
    """

    axis: FloatArray
    shots: FloatArray
    unit: Unit | None = None
    notes: tuple[str, ...] = ()
    wavelengths: bool = True
