"""Results of a run: tables, maps, spectra, files. Bulk numbers are sent as little-endian Float32."""

from typing import Any, Literal

from pydantic import Field

from .base import ApiModel


class RunFile(ApiModel):
    """A file in the run's folder."""

    name: str
    size: int
    kind: Literal["protocol", "journal", "table", "spectrum", "figure", "report", "other"]


class Column(ApiModel):
    """A column of a table; its unit is in its name's suffix."""

    name: str
    unit: str | None
    numeric: bool


class TableHead(ApiModel):
    """A table of collected rows."""

    name: str
    columns: list[Column]
    rows: int


class TableWindow(ApiModel):
    """Some rows, as columns of one length; an empty cell is null."""

    name: str
    offset: int
    total: int
    columns: dict[str, list[Any]]


class MapHead(ApiModel):
    """One column over the plane. Its cells are Float32, row by row from the lowest y."""

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


class Maps(ApiModel):
    """All maps of a run; maps of one table share x, y and the cell index."""

    maps: list[MapHead]
    cell_keys: dict[str, list[str | None]] = Field(
        description="Table -> key of each cell, in the order of the cells; null for an empty cell."
    )


class SpectrumHead(ApiModel):
    """One spectrum file of a run, and its iteration."""

    file: str
    loop: str | None
    key: str | None
    index: int | None


class Axis(ApiModel):
    """The wavelengths shared by spectra; get them once by their id."""

    id: str


class Spectra(ApiModel):
    """All spectra of a run; `axis` is that of the first."""

    spectra: list[SpectrumHead]
    axis: Axis | None


class Peak(ApiModel):
    """A fitted peak; `element` if one was identified."""

    nm: float
    area: float
    width_nm: float
    height: float
    element: str | None = None


class Peaks(ApiModel):
    """The reduction of one spectrum."""

    file: str
    axis: Axis
    peaks: list[Peak]
    areas: dict[str, float]
    temperature_k: float | None
    noise: float | None = Field(default=None, description="Median of the residual's size, counts.")


class Selection(ApiModel):
    """Iterations by their keys, as `points` and maps give them (`A/0,0` in a loop in a loop)."""

    keys: list[str] = Field(min_length=1, max_length=20_000)
    loop: str | None = Field(default=None, description="Needed where several loops have points.")


class MeasureAgain(Selection):
    """A new protocol with only those points."""

    name: str | None = Field(default=None, description="Name of the new protocol.", max_length=200)


class Reduction(ApiModel):
    """State of the reduction of a run's spectra to peaks, plasma, maps and classes."""

    state: Literal["none", "waiting", "working", "done", "failed"]
    text: str = Field(
        default="", description="What it is doing, what it has made, or why it failed."
    )
    tables: list[str] = Field(
        default_factory=list, description="Names for `tables` and `maps` that exist by now."
    )


class AgainText(ApiModel):
    """The text; not saved to a file yet."""

    name: str
    text: str
    points: int
    params: dict[str, Any] = Field(
        description="Parameters that were set for the run; pass them to the new one."
    )
