"""Look up atomic lines, levels and ionisation energies in the shipped table.

The table is compiled from the NIST Atomic Spectra Database; data/SOURCES.md says how.
Its wavelengths are vacuum wavelengths. `use_lines` adds lines of one's own.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.resources import files
from io import BytesIO
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ..spectrum.spectrum import FloatArray
from .more_lines import LinesFault, read_lines
from .table import COLUMNS, LineTable

F = TypeVar("F", bound=Callable[..., Any])

BOLTZMANN_EV_PER_K = 8.617333262e-5
# Debye lowering of the ionisation energy at 1 eV and 1e17 electrons per cm3,
# e^2 / (4 pi eps0 lambda_D) with lambda_D = 23.5 nm; levels above it are not bound.
LOWERING_EV = 0.06


@dataclass(frozen=True, slots=True, eq=False)
class Species:
    """The levels of one element in one stage of ionisation, energies ascending."""

    ionisation_ev: float
    level_ev: FloatArray
    level_g: FloatArray


@cache
def _arrays() -> dict[str, np.ndarray]:
    packed = files("labrun.reduction.data").joinpath("lines.npz").read_bytes()
    with np.load(BytesIO(packed), allow_pickle=False) as table:
        arrays = {name: table[name] for name in table.files}
    for array in arrays.values():
        array.setflags(write=False)
    return arrays


_own: dict[str, str | None] = {"text": None}
_made_of_lines: list[Any] = []


def of_lines(size: int | None = None) -> Callable[[F], F]:
    """`lru_cache` for what is computed from the line table: `use_lines` makes it forget."""

    def cached(function: F) -> F:
        kept: Any = lru_cache(size)(function)
        _made_of_lines.append(kept)
        return kept

    return cached


def use_lines(text: str | None) -> tuple[str, ...]:
    """Use the lines of a CSV file's text besides the shipped ones, in this process; None: no more.

    A line between the same levels as a shipped one replaces it. Returns sentences about rows that
    are doubtful or left out. Raises LinesFault.
    """
    notes: list[str] = []
    if text is not None and text != _own["text"]:
        known = {(str(e), int(s)) for e, s in zip(*_species_named(), strict=True)}
        table = read_lines(text, notes)
        for named in zip(table.element.tolist(), table.stage.tolist(), strict=True):
            if named not in known and named != ("H", 2):
                raise LinesFault(f"the levels of {named[0]} {'I' * named[1]} are not known")
    if text != _own["text"]:
        _own["text"] = text
        for kept in _made_of_lines:
            kept.cache_clear()
    return tuple(notes)


@of_lines()
def line_table() -> LineTable:
    """All lines, read once: those shipped, and those of `use_lines`; the arrays are read-only."""
    arrays = _arrays()
    shipped = LineTable(*(arrays[name] for name in COLUMNS))
    return shipped if _own["text"] is None else shipped.with_lines(read_lines(_own["text"]))


@of_lines()
def lines_of(element: str) -> LineTable:
    """The lines of one element, stages I and II.

    Raises ValueError when the table has none of that symbol.
    """
    table = line_table()
    found = table.where(table.element == element)
    if not len(found):
        raise ValueError(f"the line table has no lines of {element!r}")
    return found


def _species_named() -> tuple[np.ndarray, np.ndarray]:
    return _arrays()["species_element"], _arrays()["species_stage"]


@cache
def species(element: str, stage: int) -> Species:
    """The levels and ionisation energy (eV) of an element in stage 1 (I) or 2 (II).

    Raises ValueError when the table has no such species.
    """
    arrays = _arrays()
    same = (arrays["species_element"] == element) & (arrays["species_stage"] == stage)
    if not same.any():
        raise ValueError(f"the line table has no levels of {element!r} in stage {stage}")
    index = int(np.flatnonzero(same)[0])
    levels = slice(*arrays["level_offset"][index : index + 2])
    return Species(
        float(arrays["species_ionisation_ev"][index]),
        arrays["level_ev"][levels],
        arrays["level_g"][levels],
    )


def partition_function(
    element: str, stage: int, temperature_k: ArrayLike, lowering_ev: float = LOWERING_EV
) -> Any:
    """Sum of g exp(-E / kT) over the levels below the lowered ionisation energy, no unit; of one temperature
    or many."""
    found = species(element, stage)
    bound = found.level_ev < found.ionisation_ev - lowering_ev
    energies, weights = found.level_ev[bound], found.level_g[bound]
    kt = BOLTZMANN_EV_PER_K * np.asarray(temperature_k)[..., None]
    return np.sum(weights * np.exp(-energies / kt), axis=-1)
