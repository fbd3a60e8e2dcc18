"""Results: tables, maps, spectra, files, downloads, and points to measure again."""

from typing import Annotated, Literal

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response, StreamingResponse

from ..models import results as models
from ..results.exporting import exported
from .binary import BINARY, Float32Response, kept_for_ever
from .state import TheSite

router = APIRouter(tags=["results"])


@router.get("/runs/{id}/files")
async def list_files(id: str, app_state: TheSite) -> list[models.RunFile]:
    """The files of a run's folder, without the working state of engine and servers."""
    return await app_state.results.files(id)


@router.get("/runs/{id}/files/{file:path}")
async def get_file(id: str, file: str, app_state: TheSite) -> Response:
    """One file of the run's folder; scripts in pages are disabled."""
    return app_state.results.file(id, file)


@router.get("/runs/{id}/zip")
async def get_zip(id: str, app_state: TheSite) -> StreamingResponse:
    """The run's folder as a zip, without working state and without the lab's tokens."""
    return app_state.results.zip(id)


@router.get("/runs/{id}/export/{format}")
async def export_run(id: str, format: str, app_state: TheSite) -> Response:
    """The run as NeXus, MCAP, or a plug-in's format, as `labrun export` writes it."""
    return await exported(app_state.runs.place(id), format)


@router.get("/runs/{id}/tables")
async def list_tables(id: str, app_state: TheSite) -> list[models.TableHead]:
    """The tables collected by the run's loops; and, if its spectra were reduced, plasma, classes
    and element areas by point (`reduced/plasma.csv`, `maps/classes.csv`, ...)."""
    return await app_state.results.tables(id)


@router.get("/runs/{id}/tables/{table:path}/download")
async def download_table(
    id: str, table: str, app_state: TheSite, format: Literal["csv", "parquet"] = "csv"
) -> Response:
    """A table as a file, named after the run."""
    return await app_state.results.download(id, table, format)


@router.get("/runs/{id}/tables/{table:path}")
async def get_table(
    id: str, table: str, app_state: TheSite, offset: Annotated[int, Query(ge=0)] = 0,
    limit: Annotated[int, Query(ge=1, le=10_000)] = 1000,
) -> models.TableWindow:  # fmt: skip
    """Rows of a table, as columns."""
    return await app_state.results.table(id, table, offset, limit)


@router.get("/runs/{id}/maps")
async def list_maps(id: str, app_state: TheSite) -> models.Maps:
    """The columns that can be drawn over the plane."""
    return await app_state.results.maps(id)


@router.get(
    "/runs/{id}/maps/{table:path}/{column}", response_class=Float32Response, responses=BINARY
)
async def get_map(id: str, table: str, column: str, app_state: TheSite) -> Response:
    """Float32, width x height, row by row from the lowest y; NaN is a hole."""
    head, cells = await app_state.results.map(id, table, column)
    return Float32Response(cells, headers=_map_headers(head))


def _map_headers(head: models.MapHead) -> dict[str, str]:
    return {"X-Width": str(head.width), "X-Height": str(head.height)}


@router.get("/runs/{id}/spectra")
async def list_spectra(id: str, app_state: TheSite, sample: str = "") -> models.Spectra:
    """The spectra of a run, each with its iteration; with `sample` only those of it."""
    return await app_state.results.spectra(id, sample)


@router.get("/runs/{id}/axes/{axis}", response_class=Float32Response, responses=BINARY)
async def get_axis(id: str, axis: str, request: Request, app_state: TheSite) -> Response:
    """The wavelengths in nm, Float32; the same id is always the same axis."""
    return kept_for_ever(request, f"axis-{axis}", await app_state.results.axis(id, axis))


@router.get("/runs/{id}/spectrum", response_class=Float32Response, responses=BINARY)
async def get_spectrum(id: str, file: str, request: Request, app_state: TheSite) -> Response:
    """Counts, Float32; the header `X-Axis` names the wavelengths."""
    tag, axis, counts = await app_state.results.spectrum(id, file)
    return kept_for_ever(request, tag, counts, {"X-Axis": axis})


@router.get("/runs/{id}/peaks")
async def get_peaks(
    id: str, file: str, app_state: TheSite,
    elements: Annotated[list[str] | None, Query(max_length=40)] = None,
) -> models.Peaks:  # fmt: skip
    """The fitted peaks of one spectrum, with elements where identified."""
    return await app_state.results.peaks(id, file, elements)


@router.get("/runs/{id}/fit", response_class=Float32Response, responses=BINARY)
async def get_fit(id: str, file: str, app_state: TheSite) -> Response:
    """Float32, three after the other, each as long as the axis: background, fit, residual."""
    axis, curves = await app_state.results.fit(id, file)
    return Float32Response(curves, headers={"X-Axis": axis})


@router.get("/runs/{id}/curve")
async def get_curve(id: str, element: str, app_state: TheSite) -> Response:
    """The calibration curve of an element, as SVG, of a calibration that the run used."""
    return await app_state.results.curve(id, element)


@router.post("/runs/{id}/mean", response_class=Float32Response, responses=BINARY)
async def mean_spectrum(id: str, asked: models.Selection, app_state: TheSite) -> Response:
    """The mean of the selected points' spectra, Float32; `X-Count` gives their number."""
    axis, mean, count = await app_state.results.mean(id, asked)
    return Float32Response(mean, headers={"X-Axis": axis, "X-Count": str(count)})


@router.post("/runs/{id}/again")
async def measure_again(
    id: str, asked: models.MeasureAgain, app_state: TheSite
) -> models.AgainText:
    """The run's own protocol with only the selected points."""
    return await app_state.again.text(id, asked)


@router.post("/runs/{id}/reduce", status_code=202)
async def reduce_run(id: str, app_state: TheSite) -> models.Reduction:
    """Reduce the spectra to peaks, plasma, maps and classes, as `labrun reduce` and `labrun map` do.

    Runs in a separate process, and never twice at once; a notice reports its end. 409 while the run
    is live.
    """
    return app_state.reducing.start(id)


@router.get("/runs/{id}/reduction")
async def get_reduction(id: str, app_state: TheSite) -> models.Reduction:
    """Progress of the reduction."""
    return app_state.reducing.state(id)
