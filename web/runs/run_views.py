"""A run as the page sees it: in the list, its present state, all of it, and windows of its points."""

from ...engine.journal.course import Goal
from ...schemas import journal as j
from ..local.clock import iso
from ..models.runs import (
    Loop,
    NeedsYou,
    Now,
    OutlineNode,
    Points,
    Question,
    RunDetail,
    RunHead,
    RunSummary,
)
from .counts import Table
from .open_run import OpenRun
from .pace import eta, per_minute


def summary(run: OpenRun) -> RunSummary:
    """The run as in the list of runs."""
    picture, inputs = run.picture, run.inputs
    started, finished = picture.started, picture.finished
    loops = [table for table in picture.outer_tables() if table.loop.startswith("main")]
    totals = [table.total for table in loops]
    over = _eta(run)
    fate = run.fate
    done = sum(table.done for table in loops)
    failed = sum(table.counts.get("failed", 0) for table in loops)
    total = sum(t or 0 for t in totals) if totals and None not in totals else None
    reason = (finished.reason if finished is not None else "") or run.damage
    if fate == "interrupted":
        reason = reason or "its engine is gone: resume it"
    return RunSummary(
        id=run.id, protocol=started.protocol if started is not None else inputs.title,
        file=inputs.file, fate=fate, reason=reason, live=run.live,
        began_at=run.began_at, ended_at=finished.at if finished is not None else None,
        word=j.ended_as(fate, picture.hole_count), done=done, measured=done - failed, failed=failed,
        left=None if total is None else max(0, total - done), total=total,
        holes=picture.hole_count, resumes=picture.resumes, operator=inputs.launch.operator,
        questions=len(picture.open_questions), now=_now_text(run),
        eta=None if over is None else (iso(over[0]), iso(over[1])),
    )  # fmt: skip


def head(run: OpenRun) -> RunHead:
    """Everything that changes, except steps and points."""
    picture = run.picture
    first = next(iter(picture.outer_tables()), None)
    return RunHead(
        **summary(run).model_dump(), phase=picture.phase, pausing=run.pausing is not None,
        loops=[_loop(run, node) for node in _outline(run) if node.loop],
        under_way=[_now(run, one) for one in picture.under_way.values()],
        open_questions=[Question.of(asked) for asked in picture.open_questions.values()],
        needs_you=_needs_you(run),
        per_minute=per_minute(first) if first is not None and run.live else None,
        retries=picture.retries, lines=len(picture.log), stands=bool(picture.stands),
    )  # fmt: skip


def detail(run: OpenRun) -> RunDetail:
    """All of it."""
    picture = run.picture
    return RunDetail(
        **head(run).model_dump(), outline=_outline(run), nodes=picture.states(),
        params=picture.params, roles=picture.roles,
        outputs=picture.finished.outputs if picture.finished is not None else {},
        launch=run.inputs.launch,
        protocol_text=run.inputs.text, changes=len(picture.changes), seq=run.seq,
    )  # fmt: skip


def points(run: OpenRun, loop: str, within: str, offset: int, limit: int) -> Points:
    """A window of a loop's iterations in the order of their items."""
    table = run.picture.tables.get((loop, within)) or Table(loop, within)
    items = run.picture.items(loop)
    total = table.total if table.total is not None else (items.total if items else None)
    over = max(total or 0, max(table.by_index, default=-1) + 1)
    window = range(min(offset, over), min(offset + limit, over))
    places = [items.place(index) for index in window] if items else [(None, None)] * len(window)
    return Points(
        loop=loop, total=total, offset=offset, index=list(window),
        x_mm=[x for x, _ in places], y_mm=[y for _, y in places], **table.columns(window),
    )  # fmt: skip


def _outline(run: OpenRun) -> list[OutlineNode]:
    return run.inputs.outline.nodes if run.inputs.outline is not None else []


def _loop(run: OpenRun, node: OutlineNode) -> Loop:
    tables = [table for table in run.picture.tables.values() if table.loop == node.path]
    items = run.picture.items(node.path)
    current = [table.keys[table.current] for table in tables if table.current is not None]
    total = items.total if items else None
    if "*" not in node.path and tables and tables[0].total is not None:
        total = tables[0].total
    return Loop(
        path=node.path, title=node.title, total=total, done=sum(t.done for t in tables),
        succeeded=sum(t.counts.get("ok", 0) for t in tables),
        failed=sum(t.counts.get("failed", 0) for t in tables),
        skipped=sum(t.counts.get("skipped", 0) for t in tables),
        current=current[-1] if current else None, placed=bool(items and items.placed),
    )  # fmt: skip


def _now(run: OpenRun, one: Goal) -> Now:
    found = run.inputs.outline.find(one.path) if run.inputs.outline is not None else None
    loop, key = found.innermost if found is not None else (None, None)
    spread = run.timings.spread(one.record.label)
    progress, message = run.feedback.get(one.path, (None, ""))
    return Now(
        id=one.record.id, path=one.path,
        node=found.step.told.path if found is not None else "", loop=loop, key=key,
        device=one.record.device, action=one.record.action, attempt=one.attempt,
        since=one.record.at, progress=progress, message=message,
        usual_s=None if spread is None else (spread.low, spread.high),
    )  # fmt: skip


def _now_text(run: OpenRun) -> str:
    if not run.live:
        return ""
    if run.picture.open_questions:
        return next(iter(run.picture.open_questions.values())).text
    if run.picture.paused:
        return "paused"
    return ", ".join(sorted({one.record.label for one in run.picture.under_way.values()}))


def _eta(run: OpenRun) -> tuple[float, float] | None:
    if not run.live or run.picture.finished is not None or run.picture.paused:
        return None
    tables = reversed(run.picture.outer_tables())
    return next((over for table in tables if (over := eta(table)) is not None), None)


def _needs_you(run: OpenRun) -> NeedsYou | None:
    """The next step with a question: it comes after the loop before it."""
    over = _eta(run)
    if over is None:
        return None
    behind = run.picture.nodes.keys() | run.picture.passed().keys()
    for node in _outline(run):
        waiting = node.path not in behind and node.path.startswith("main/")
        if node.kind in ("confirm", "ask") and waiting and "*" not in node.path:
            return NeedsYou(text=node.title, low=iso(over[0]), high=iso(over[1]))
    return None
