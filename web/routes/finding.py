"""Runs found again, compared and labelled; samples; a number over many runs."""

from typing import Annotated

from fastapi import APIRouter, Query

from ..access.headers import ByName, PerhapsInTime
from ..models import finding as models
from .state import TheSite

router = APIRouter(tags=["finding"])
Find = Annotated[str, Query(max_length=500)]
Limit = Annotated[str, Query(max_length=100, description="`0.5 mm`, or `3` in the number's unit.")]


@router.get("/found")
async def found_runs(
    app_state: TheSite, find: Find = "", offset: Annotated[int, Query(ge=0)] = 0,
    limit: Annotated[int, Query(ge=1, le=10_000)] = 200,
) -> models.FoundRuns:  # fmt: skip
    """Runs for which a search holds (as `labrun runs --find`), newest first."""
    return await app_state.finding.found(find, offset, limit)


@router.get("/found/numbers")
async def found_numbers(
    name: str, app_state: TheSite, find: Find = "", low: Limit = "", high: Limit = ""
) -> models.RunNumbers:
    """One number over those runs: an output, a parameter, TABLE.COLUMN; limits are computed, or given."""
    return await app_state.finding.numbers(name, find, low, high)


@router.get("/compared")
async def compared_runs(
    run: Annotated[list[str], Query(max_length=20)], app_state: TheSite
) -> models.Compared:
    """Two to eight runs beside each other."""
    return await app_state.finding.compared(run)


@router.get("/samples")
async def list_samples(app_state: TheSite) -> list[models.Sample]:
    """Every sample that a run was measured on, the latest first."""
    return await app_state.finding.samples()


@router.get("/samples/{sample:path}")
async def sample_runs(sample: str, app_state: TheSite) -> list[models.FoundRun]:
    """The runs of one sample, newest first."""
    return await app_state.finding.of_sample(sample)


@router.get("/runs/{id}/labels")
async def get_labels(id: str, app_state: TheSite) -> models.RunLabels:
    """Sample, tags and note that people gave a run."""
    return app_state.finding.labels(id)


@router.get("/runs/{id}/snapshots")
async def list_snapshots(id: str, app_state: TheSite) -> list[models.RunSnapshot]:
    """Pictures that people took of the bench into a run; each is one of its files."""
    return app_state.snapshots.of(id)


@router.post("/runs/{id}/snapshots")
async def take_snapshot(
    id: str, asked: models.TakeSnapshot, app_state: TheSite, by: ByName, in_time: PerhapsInTime
) -> models.RunSnapshot:
    """Take what a camera sees now into a run; needs no control, as it moves nothing."""
    return await app_state.snapshots.take(id, asked.device, by)


@router.put("/runs/{id}/labels")
async def put_labels(id: str, asked: models.RunLabels, app_state: TheSite) -> models.RunLabels:
    """Change them; nothing that was measured changes."""
    return app_state.finding.label(id, asked)
