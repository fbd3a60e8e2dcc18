"""Results of a run: tables, maps, spectra, files. Numbers in bulk travel as little-endian Float32."""

from typing import Any, Literal

from pydantic import Field

from .told import Told


class RunFile(Told):
    """A file in the run's folder."""

    name: str
    size: int
    kind: Literal["protocol", "journal", "table", "spectrum", "figure", "report", "other"]


class Column(Told):
    """A column of a table; its unit is in its name's suffix."""

    name: str
    unit: str | None
    numeric: bool


class TableHead(Told):
    """A table of collected rows."""

    name: str
    columns: list[Column]
    rows: int


class TableWindow(Told):
    """Some rows, as columns of one length; an empty cell is null."""

    name: str
    offset: int
    total: int
    columns: dict[str, list[Any]]


class MapHead(Told):
    """One column over the plane. Its cells come as Float32, row by row from the lowest y."""

    table: str
    column: str
    element: bool
    unit: str
    width: int
    height: int
    x: list[float]
    y: list[float]
    measured: int
    minimum: float | None
    maximum: float | None
    p2: float | None
    p98: float | None


class Maps(Told):
    """All maps of a run; those of one table share x, y and the index of cells."""

    maps: list[MapHead]
    cell_keys: dict[str, list[str | None]] = Field(
        description="Table -> key of each cell, in the order of the cells; null where none is."
    )


class SpectrumHead(Told):
    """One spectrum file of a run, and the iteration that it belongs to."""

    file: str
    loop: str | None
    key: str | None
    index: int | None


class Axis(Told):
    """The wavelengths that spectra share; get them once by their id."""

    id: str
    channels: int
    from_nm: float
    to_nm: float


class Spectra(Told):
    """All spectra of a run; `axis` is that of the first."""

    spectra: list[SpectrumHead]
    axis: Axis | None


class Peak(Told):
    """A fitted peak; `element` where one was found for it."""

    nm: float
    area: float
    width_nm: float
    height: float
    element: str | None = None


class Peaks(Told):
    """What the reduction says of one spectrum."""

    file: str
    axis: Axis
    peaks: list[Peak]
    areas: dict[str, float]
    temperature_k: float | None
    noise: float | None = Field(default=None, description="Median of the residual's size, counts.")


class Selection(Told):
    """Iterations by their keys, as `points` and maps give them (`A/0,0` in a loop in a loop)."""

    keys: list[str] = Field(min_length=1, max_length=20_000)
    loop: str | None = Field(default=None, description="Needed where several loops have points.")


class MeasureAgain(Selection):
    """A new protocol with just those points."""

    name: str | None = Field(default=None, description="What it is to be called.", max_length=200)


class Reduction(Told):
    """What became of reducing a run's spectra to peaks, plasma, maps and classes."""

    state: Literal["none", "waiting", "working", "done", "failed"]
    text: str = Field(default="", description="What it does now, has made, or why it failed.")
    tables: list[str] = Field(
        default_factory=list, description="Names for `tables` and `maps` that are there by now."
    )


class AgainText(Told):
    """The text; it is in no file yet."""

    name: str
    text: str
    points: int
    params: dict[str, Any] = Field(description="What the run had set; give them to the new one.")
