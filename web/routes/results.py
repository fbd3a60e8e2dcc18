"""Results: tables, maps, spectra, files, downloads, and what to measure again."""

from typing import Annotated, Literal

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response, StreamingResponse

from ..models.results import (
    AgainText,
    MapHead,
    Maps,
    MeasureAgain,
    Peaks,
    Reduction,
    RunFile,
    Selection,
    Spectra,
    TableHead,
    TableWindow,
)
from .binary import BINARY, Float32Response, kept_for_ever
from .site import TheSite

router = APIRouter(tags=["results"])


@router.get("/runs/{id}/files")
async def list_files(id: str, site: TheSite) -> list[RunFile]:
    """The files of a run's folder, without the working state of engine and servers."""
    return await site.results.files(id)


@router.get("/runs/{id}/files/{file:path}")
async def get_file(id: str, file: str, site: TheSite) -> Response:
    """One file of the run's folder; pages come without scripts."""
    return site.results.file(id, file)


@router.get("/runs/{id}/zip")
async def get_zip(id: str, site: TheSite) -> StreamingResponse:
    """The run's folder as a zip, without working state and without the lab's tokens."""
    return site.results.zip(id)


@router.get("/runs/{id}/tables")
async def list_tables(id: str, site: TheSite) -> list[TableHead]:
    """The tables that the run's loops collected; and, where its spectra were reduced, plasma,
    classes and areas of elements by point (`reduced/plasma.csv`, `maps/classes.csv`, ...)."""
    return await site.results.tables(id)


@router.get("/runs/{id}/tables/{table:path}/download")
async def download_table(
    id: str, table: str, site: TheSite, format: Literal["csv", "parquet"] = "csv"
) -> Response:
    """A table as a file, named after the run."""
    return await site.results.download(id, table, format)


@router.get("/runs/{id}/tables/{table:path}")
async def get_table(
    id: str, table: str, site: TheSite, offset: Annotated[int, Query(ge=0)] = 0,
    limit: Annotated[int, Query(ge=1, le=10_000)] = 1000,
) -> TableWindow:  # fmt: skip
    """Rows of a table, as columns."""
    return await site.results.table(id, table, offset, limit)


@router.get("/runs/{id}/maps")
async def list_maps(id: str, site: TheSite) -> Maps:
    """The columns that can be drawn over the plane."""
    return await site.results.maps(id)


@router.get(
    "/runs/{id}/maps/{table:path}/{column}", response_class=Float32Response, responses=BINARY
)
async def get_map(id: str, table: str, column: str, site: TheSite) -> Response:
    """Float32, width x height, row by row from the lowest y; NaN is a hole."""
    head, cells = await site.results.map(id, table, column)
    return Float32Response(cells, headers=_map_headers(head))


def _map_headers(head: MapHead) -> dict[str, str]:
    return {"X-Width": str(head.width), "X-Height": str(head.height)}


@router.get("/runs/{id}/spectra")
async def list_spectra(id: str, site: TheSite) -> Spectra:
    """The spectra of a run, each with its iteration."""
    return await site.results.spectra(id)


@router.get("/runs/{id}/axes/{axis}", response_class=Float32Response, responses=BINARY)
async def get_axis(id: str, axis: str, request: Request, site: TheSite) -> Response:
    """The wavelengths in nm, Float32; the same id is always the same axis."""
    return kept_for_ever(request, f"axis-{axis}", await site.results.axis(id, axis))


@router.get("/runs/{id}/spectrum", response_class=Float32Response, responses=BINARY)
async def get_spectrum(id: str, file: str, request: Request, site: TheSite) -> Response:
    """Counts, Float32; the header `X-Axis` names the wavelengths."""
    tag, axis, counts = await site.results.spectrum(id, file)
    return kept_for_ever(request, tag, counts, {"X-Axis": axis})


@router.get("/runs/{id}/peaks")
async def get_peaks(
    id: str, file: str, site: TheSite,
    elements: Annotated[list[str] | None, Query(max_length=40)] = None,
) -> Peaks:  # fmt: skip
    """The fitted peaks of one spectrum, those of elements with their names."""
    return await site.results.peaks(id, file, elements)


@router.get("/runs/{id}/fit", response_class=Float32Response, responses=BINARY)
async def get_fit(id: str, file: str, site: TheSite) -> Response:
    """Float32, three after the other, each as long as the axis: background, fit, residual."""
    axis, curves = await site.results.fit(id, file)
    return Float32Response(curves, headers={"X-Axis": axis})


@router.post("/runs/{id}/mean", response_class=Float32Response, responses=BINARY)
async def mean_spectrum(id: str, asked: Selection, site: TheSite) -> Response:
    """The mean of the selected points' spectra, Float32; `X-Count` says of how many."""
    axis, mean, count = await site.results.mean(id, asked)
    return Float32Response(mean, headers={"X-Axis": axis, "X-Count": str(count)})


@router.post("/runs/{id}/again")
async def measure_again(id: str, asked: MeasureAgain, site: TheSite) -> AgainText:
    """A protocol like the run's own, with only the selected points."""
    return await site.again.text(id, asked)


@router.post("/runs/{id}/reduce", status_code=202)
async def reduce_run(id: str, site: TheSite) -> Reduction:
    """Reduce its spectra to peaks, plasma, maps and classes, as `labrun reduce` and `labrun map` do.

    It goes on in a process of its own, and is not begun twice; a notice tells of its end. 409 while
    the run is live.
    """
    return site.reducing.start(id)


@router.get("/runs/{id}/reduction")
async def get_reduction(id: str, site: TheSite) -> Reduction:
    """How far that is."""
    return site.reducing.state(id)
