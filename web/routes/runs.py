"""Runs: start, look, pause, continue, abort, answer, resume."""

from typing import Annotated

from fastapi import APIRouter, Query

from ..guard.headers import CommandKey, InTime, Operator, PerhapsInTime
from ..guard.once import CommandRoute
from ..models.runs import (
    AnswerQuestion,
    Changes,
    LaunchState,
    LogWindow,
    PauseRun,
    PointDetail,
    Points,
    ResumeRun,
    RunDetail,
    RunSummary,
    StartRun,
)
from ..models.told import Said
from .site import TheSite

router = APIRouter(tags=["runs"])
commands = APIRouter(tags=["runs"], route_class=CommandRoute)
Offset = Annotated[int, Query(ge=0)]
Limit = Annotated[int, Query(ge=1, le=10_000)]


@router.get("/runs")
async def list_runs(site: TheSite) -> list[RunSummary]:
    """All runs, newest first; live ones are those whose engine answers."""
    return await site.runs.summaries()


@commands.post("/runs", status_code=202)
async def start_run(
    asked: StartRun, site: TheSite, by: Operator, in_time: InTime, key: CommandKey
) -> LaunchState:
    """Check and start a protocol in an engine of its own; 422 with all problems.

    The answer comes when the run has a name, or after 2 s; then `GET /launches/{id}` tells it.
    """
    return await site.launching.start(asked, by, key, in_time)


@router.get("/launches/{id}")
async def get_launch(id: str, site: TheSite) -> LaunchState:
    """An engine that was started: which run it is, or why it did not come up."""
    return site.launching.launch(id)


@router.get("/runs/{id}")
async def get_run(id: str, site: TheSite) -> RunDetail:
    """A run, live or finished, from its journal."""
    return (await site.runs.opened(id)).detail()


@router.get("/runs/{id}/points")
async def get_points(
    id: str, site: TheSite, loop: str, within: str = "", offset: Offset = 0, limit: Limit = 5000
) -> Points:
    """A window of a loop's iterations; `loop` is its pattern, `within` the keys around it."""
    return (await site.runs.opened(id)).points(loop, within, offset, limit)


@router.get("/runs/{id}/point")
async def get_point(id: str, site: TheSite, loop: str, key: str, within: str = "") -> PointDetail:
    """Everything about one iteration."""
    run = await site.runs.opened(id)
    return await site.runs.point(run, loop, within, key)


@router.get("/runs/{id}/log")
async def get_log(
    id: str, site: TheSite, after: int | None = None, before: int | None = None,
    limit: Annotated[int, Query(ge=1, le=2000)] = 200, problems: bool = False,
    device: str | None = None, find: Annotated[str, Query(max_length=200)] = "",
) -> LogWindow:  # fmt: skip
    """A window of the log: the last lines, or those before or after a line's `n`."""
    run = await site.runs.opened(id)
    return run.log(after, before, limit, problems=problems, device=device, find=find)


@commands.post("/runs/{id}/pause")
async def pause_run(id: str, asked: PauseRun, site: TheSite, in_time: PerhapsInTime) -> Said:
    """Pause; needs no control."""
    return await site.telling.pause(id, asked.when)


@commands.post("/runs/{id}/continue")
async def continue_run(
    id: str, site: TheSite, by: Operator, in_time: InTime, key: CommandKey
) -> Said:
    """Go on after a pause; also takes back a pause that was to come after this point."""
    return await site.telling.go_on(id, by, in_time)


@commands.post("/runs/{id}/abort")
async def abort_run(id: str, site: TheSite, by: Operator, in_time: InTime, key: CommandKey) -> Said:
    """Cancel, run `finally`, put the devices into their safe state; a second time: at once."""
    return await site.telling.abort(id, by, in_time)


@commands.post("/runs/{id}/questions/{question:path}")
async def answer_question(
    id: str, question: str, asked: AnswerQuestion, site: TheSite,
    by: Operator, in_time: InTime, key: CommandKey,
) -> Said:  # fmt: skip
    """Answer an open question, by its id or path."""
    return await site.telling.answer(id, question, asked.choice, by, in_time)


@commands.post("/runs/{id}/resume", status_code=202)
async def resume_run(
    id: str, asked: ResumeRun, site: TheSite, by: Operator, in_time: InTime, key: CommandKey
) -> LaunchState:
    """Go on at the first unfinished action, in a new engine."""
    return await site.launching.resume(id, asked, by, key, in_time)


@router.post("/runs/{id}/changes")
async def run_changes(id: str, asked: ResumeRun, site: TheSite) -> Changes:
    """What is different in the protocol (or parameters) with which the run could go on."""
    return await site.resuming.changes(id, asked)


@router.post("/runs/{id}/report")
async def make_report(id: str, site: TheSite) -> Said:
    """Make report and figures again."""
    return await site.runs.report(id)
