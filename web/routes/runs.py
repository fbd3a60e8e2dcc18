"""Runs: start, look, pause, continue, abort, answer, resume."""

from typing import Annotated

from fastapi import APIRouter, Query

from ..access.headers import ByName, CommandKey, InTime, Operator, PerhapsInTime
from ..access.once import CommandRoute
from ..models import runs as models
from ..models.base import Answer
from ..runs.run_views import detail, points
from .state import TheSite

router = APIRouter(tags=["runs"])
commands = APIRouter(tags=["runs"], route_class=CommandRoute)
Offset = Annotated[int, Query(ge=0)]
Limit = Annotated[int, Query(ge=1, le=10_000)]


@router.get("/runs")
async def list_runs(app_state: TheSite) -> list[models.RunSummary]:
    """All runs, newest first; live ones are those whose engine answers."""
    return await app_state.runs.summaries()


@commands.post("/runs", status_code=202)
async def start_run(
    asked: models.StartRun, app_state: TheSite, by: Operator, in_time: InTime, key: CommandKey
) -> models.LaunchState:
    """Check and start a protocol in a separate engine; 422 with all problems.

    Answers when the run has a name, or after 2 s; then `GET /launches/{id}` gives it.
    """
    return await app_state.launching.start(asked, by, key, in_time)


@router.get("/launches/{id}")
async def get_launch(id: str, app_state: TheSite) -> models.LaunchState:
    """A started engine: which run it is, or why it failed to start."""
    return app_state.launching.launch(id)


@router.get("/releases")
def list_releases(app_state: TheSite) -> list[models.Released]:
    """What people have released for one start by a program, and none has started yet."""
    return app_state.releasing.all()


@router.post("/releases")
async def prepare_release(asked: models.StartRun, app_state: TheSite) -> models.ToRelease:
    """Copy all that a run would use, and tell it in words; nothing is released yet."""
    return await app_state.releasing.prepare(asked)


@router.post("/releases/{id}")
async def give_release(id: str, asked: models.GiveRelease, app_state: TheSite) -> models.Released:
    """Release what was prepared: a program may start it, once, as it was read."""
    return await app_state.releasing.release(id, asked.by)


@router.delete("/releases/{id}")
async def take_back_release(id: str, app_state: TheSite) -> Answer:
    """Take a release back, or leave what was prepared."""
    app_state.releasing.take_back(id)
    return Answer(text="it is released no more")


@router.get("/runs/{id}")
async def get_run(id: str, app_state: TheSite) -> models.RunDetail:
    """A run, live or finished, from its journal."""
    return detail(await app_state.runs.opened(id))


@router.get("/runs/{id}/points")
async def get_points(
    id: str,
    app_state: TheSite,
    loop: str,
    within: str = "",
    offset: Offset = 0,
    limit: Limit = 5000,
) -> models.Points:
    """A window of a loop's iterations; `loop` is its pattern, `within` the keys around it."""
    return points(await app_state.runs.opened(id), loop, within, offset, limit)


@router.get("/runs/{id}/point")
async def get_point(
    id: str, app_state: TheSite, loop: str, key: str, within: str = ""
) -> models.PointDetail:
    """Everything about one iteration."""
    run = await app_state.runs.opened(id)
    return await app_state.runs.point(run, loop, within, key)


@router.get("/runs/{id}/log")
async def get_log(
    id: str, app_state: TheSite, after: int | None = None, before: int | None = None,
    limit: Annotated[int, Query(ge=1, le=2000)] = 200, problems: bool = False,
    device: str | None = None, find: Annotated[str, Query(max_length=200)] = "",
) -> models.LogWindow:  # fmt: skip
    """A window of the log: the last lines, or those before or after a line's `n`."""
    run = await app_state.runs.opened(id)
    return run.picture.log.window(
        run.inputs.outline, after, before, limit, problems=problems, device=device, find=find
    )


@commands.post("/runs/{id}/pause")
async def pause_run(
    id: str, asked: models.PauseRun, app_state: TheSite, in_time: PerhapsInTime, by: ByName
) -> Answer:
    """Pause; needs no control."""
    return await app_state.commands.pause(id, asked.when, by)


@commands.post("/runs/{id}/continue")
async def continue_run(
    id: str, app_state: TheSite, by: Operator, in_time: InTime, key: CommandKey
) -> Answer:
    """Continue after a pause; also revokes a pause requested for after this point."""
    return await app_state.commands.go_on(id, by, in_time)


@commands.post("/runs/{id}/abort")
async def abort_run(
    id: str, app_state: TheSite, by: Operator, in_time: InTime, key: CommandKey
) -> Answer:
    """Cancel, run `finally`, put the devices into their safe state; a second time: at once."""
    return await app_state.commands.abort(id, by, in_time)


@commands.post("/runs/{id}/questions/{question:path}")
async def answer_question(
    id: str, question: str, asked: models.AnswerQuestion, app_state: TheSite,
    by: Operator, in_time: InTime, key: CommandKey,
) -> Answer:  # fmt: skip
    """Answer an open question, by its id or path."""
    return await app_state.commands.answer(id, question, asked, by, in_time)


@commands.post("/runs/{id}/resume", status_code=202)
async def resume_run(
    id: str,
    asked: models.ResumeRun,
    app_state: TheSite,
    by: Operator,
    in_time: InTime,
    key: CommandKey,
) -> models.LaunchState:
    """Resume at the first unfinished action, in a new engine."""
    return await app_state.launching.resume(id, asked, by, key, in_time)


@commands.post("/runs/{id}/change", status_code=202)
async def change_run(
    id: str, asked: models.ResumeRun, app_state: TheSite, by: Operator, in_time: InTime,
    key: CommandKey,
) -> Answer:  # fmt: skip
    """Let a live run go on with a changed protocol, between two actions; says so if that takes longer."""
    return await app_state.commands.change(id, asked, by, in_time)


@router.post("/runs/{id}/changes")
async def run_changes(id: str, asked: models.ResumeRun, app_state: TheSite) -> models.Changes:
    """The differences in the protocol (or parameters) with which the run could be resumed."""
    return await app_state.resuming.changes(id, asked)


@router.post("/runs/{id}/report")
async def make_report(id: str, app_state: TheSite) -> Answer:
    """Make report and figures again."""
    return await app_state.runs.report(id)
