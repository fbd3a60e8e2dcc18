"""Report chapters on the work itself: what was asked for, on which devices, when, by which actions."""

import math
from itertools import groupby

from ...engine.journal.gantt import marks
from .counts import KEPT
from .formatting import count, duration, moment, seconds_between, value
from .html import (
    BREAK,
    Html,
    at_time,
    code,
    facts,
    folded,
    join,
    label,
    paragraph,
    section,
    table,
    tag,
)
from .inputs import contract_file
from .journal_digest import interruptions
from .report_data import ReportData
from .spans import EngineSpan

PROTOCOL_SHOWN = 200_000
COLUMNS, MARKS, SHADES = 240, 8, 5
"""Of the Gantt chart."""


def provenance(title: str, data: ReportData) -> Html:
    """The run's id and times, its parameters, its devices with their servers, its protocol."""
    inputs = data.inputs
    text = inputs.protocol_text[:PROTOCOL_SHOWN]
    return section(
        "provenance", title,
        facts(_facts(data)), _params(data), _devices(data), _loops(data),
        folded(f"The protocol of this run ({inputs.protocol_name})", tag("pre", tag("code", text)))
        if text else "",
    )  # fmt: skip


def _facts(data: ReportData) -> list[tuple[str, object]]:
    digest, spans = data.digest, data.digest.spans
    rows: list[tuple[str, object]] = [("Run", code(data.folder.name))]
    if data.inputs.simulated:
        rows.append(("Devices", "simulated: no real device was used"))
    if digest.began:
        rows += [("Began (UTC)", moment(digest.began)), ("Last record (UTC)", moment(digest.ended))]
        rows.append(("Running time", duration(spans.running_s - spans.paused_s)))
    if len(spans.lives) > 1:
        told = f"{len(spans.lives) - 1}, {duration(spans.away_s)} in all"
        rows.append(("Interruptions", told))
    if spans.paused_s:
        rows.append(("Paused", duration(spans.paused_s)))
    for name, loop in list(digest.loops.items())[:3]:
        rows.append(
            (
                f"Iterations of {name.removeprefix('main/')}",
                f"{loop.total:,}, {loop.failed:,} left out",
            )
        )
    if digest.started is not None:
        rows.append(("Made by", f"labrun {digest.started.labrun}, Python {digest.started.python}"))
    return rows


def _params(data: ReportData) -> Html:
    started, inputs = data.digest.started, data.inputs
    if started is None:
        return Html()
    rows = (
        (
            code(name), value(told), "set for this run" if inputs.given(name) else "default",
            inputs.param(name).get("summary", ""),
        )
        for name, told in started.params.items()
    )  # fmt: skip
    return table("Parameters", ["name", "value", "source", "meaning"], rows)


def _devices(data: ReportData) -> Html:
    inputs = data.inputs
    rows = []
    for role, device in data.roles.items():
        boots = data.digest.boots.get(device, [])
        again = f", started {len(boots)} times" if len(boots) > 1 else ""
        server = (
            join([code(boots[-1].boot), again, BREAK, "ledger ", code(boots[-1].ledger)])
            if boots
            else tag("span", "no goal was sent to this device", class_="soft")
        )
        contract = inputs.contract_of(device)
        rows.append((
            code(role), device, join([contract, BREAK, code(contract_file(contract))]),
            inputs.reached_by(device), server,
        ))  # fmt: skip
    header = ["role", "device", "contract", "driver or address", "server (boot)"]
    return table("Devices", header, rows)


def _loops(data: ReportData) -> Html:
    rows = (
        (code(name), f"{n.total:,}", f"{n.succeeded:,}", f"{n.failed:,}", f"{n.skipped:,}")
        for name, n in data.digest.loops.items()
    )
    header = ["loop", "iterations", "succeeded", "left out (holes)", "skipped"]
    return table("Loops", header, rows, numbers=".nnnn")


def when(title: str, data: ReportData) -> Html:
    """The engine sessions, the interruptions between them, and the pauses."""
    digest = data.digest
    if not digest.spans.lives:
        return section("when", title, paragraph("The journal has no readable record."))
    rows = [_engine_row(life, data) for life in digest.spans.lives]
    header = [
        "engine",
        "began (UTC)",
        "last record (UTC)",
        "duration",
        "goals sent",
        "how it ended",
    ]
    holds = (
        (
            at_time(hold.began), hold.by, at_time(hold.ended) if hold.ended else "", hold.ended_by,
            duration(seconds_between(hold.began, hold.ended)) if hold.ended else "still paused",
        )
        for hold in digest.spans.holds
    )  # fmt: skip
    return section(
        "when", title, _bar(data),
        table("Engine sessions of this run, in order", header, rows, numbers="...nn."),
        table(
            "Interruptions: no engine was running",
            ["after", "from (UTC)", "until (UTC)", "duration", "actions under way at the start"],
            (
                (
                    f"engine {last.number}", at_time(last.ended), at_time(following.began),
                    duration(seconds_between(last.ended, following.began)),
                    count(last.under_way, "action"),
                )
                for last, following in interruptions(digest)
            ),
            numbers="...n.",
        ),
        _changes(data), _redone(data),
        table("Pauses", ["from (UTC)", "by", "until (UTC)", "ended by", "duration"], holds, numbers="....n"),
    )  # fmt: skip


def _changes(data: ReportData) -> Html:
    rows = (
        (
            at_time(change.at), code(change.folder),
            ", ".join(f"{name} = {value(told)}" for name, told in change.params.items()),
            f"{len(change.reopened):,}",
        )
        for change in data.digest.changes
    )  # fmt: skip
    header = ["when (UTC)", "new protocol and lab", "parameters", "iterations repeated"]
    return table("Changes during the run", header, rows, numbers="...n")


def _redone(data: ReportData) -> Html:
    rows = (
        (at_time(redo.at), redo.by, f"{redo.pass_number}", f"{len(redo.iterations):,}")
        for redo in data.digest.redone
    )
    header = ["when (UTC)", "asked for by", "pass", "points"]
    return table("Holes that were measured again", header, rows, numbers="..nn")


def _engine_row(life: EngineSpan, data: ReportData) -> tuple[object, ...]:
    last = life is data.digest.spans.lives[-1]
    ended = f"{life.fate}{f': {life.reason}' if life.reason else ''}" if life.fate else ""
    if not ended and last and data.fate == "running":
        ended = "still running"
    if not ended:
        left = f", {count(life.under_way, 'action')} under way" if life.under_way else ""
        ended = f"ended without a last record (killed, or power lost){left}"
    if life.torn:
        ended += f"; at its start the journal's last record was incomplete: {life.torn} bytes were cut off"
    return (
        f"{life.number} (labrun {life.labrun})", at_time(life.began), at_time(life.ended),
        duration(life.seconds), f"{life.goals:,}", ended,
    )  # fmt: skip


def _bar(data: ReportData) -> Html:
    """The run as a bar: green while an engine ran, red in between; nothing for one session only."""
    digest = data.digest
    lives = digest.spans.lives
    if len(lives) < 2:
        return Html()
    parts: list[tuple[str, float]] = [("ran", lives[0].seconds)]
    for last, following in interruptions(digest):
        parts.append(("away", seconds_between(last.ended, following.began)))
        parts.append(("ran", following.seconds))
    whole = sum(length for _, length in parts) or 1.0
    pieces = (tag("span", class_=k, style=f"width:{100 * s / whole:.3f}%") for k, s in parts)
    words = f"{len(lives)} engine sessions, {len(lives) - 1} interruptions"
    legend = paragraph(tag("span", "Green: an engine was running; red: none was.", class_="soft"))
    return join([tag("div", *pieces, class_="bar", role="img", aria_label=words), legend])


def actions(title: str, data: ReportData) -> Html:
    """How many actions of each kind were sent, and their outcomes."""
    rows = []
    for told, deed in sorted(data.digest.deeds.items()):
        rows.append((
            label(told), f"{deed.sent:,}", f"{deed.succeeded:,}", _marked(deed.failed),
            f"{deed.cancelled:,}", f"{deed.again:,}", _marked(deed.sent - deed.ended),
            duration(deed.mean_s) if deed.timed else "",
            duration(deed.longest_s) if deed.timed else "",
        ))  # fmt: skip
    header = [
        "action", "sent", "succeeded", "failed", "cancelled", "repetitions", "outcome unknown",
        "mean", "longest",
    ]  # fmt: skip
    return section(
        "actions", title,
        table("Goals by device and action", header, rows, numbers=".nnnnnnnn"), _gantt(data),
    )  # fmt: skip


def _gantt(data: ReportData) -> Html:
    """A line for each action, the darker the more of the time it was under way; without interruptions."""
    lasted_s = data.digest.spans.running_s
    rows = [
        (label(name), _line(name, row), duration(sum(row) * lasted_s / COLUMNS))
        for name, row in data.digest.gantt.rows(COLUMNS, lasted_s).items()
    ]
    if not rows:
        return Html()
    written = (
        tag("span", words, style=f"left:{100 * at_s / lasted_s:.2f}%")
        for at_s, words in marks(0.0, lasted_s, MARKS)
    )
    away = ", interruptions left out" if len(data.digest.spans.lives) > 1 else ""
    axis = tag("div", *written, class_="axis")
    return table(
        f"What each device did when, over {duration(lasted_s)}{away}", ["action", axis, "under way"], rows,
        numbers="..n",
    )  # fmt: skip


def _line(name: str, row: list[float]) -> Html:
    """As a picture: columns alike are drawn as one."""
    pieces, at = [], 0
    for part, same in groupby(math.ceil(part * SHADES) / SHADES for part in row):
        wide = len(list(same))
        if part:
            pieces.append(tag("rect", x=f"{at}", width=f"{wide}", height="1", opacity=f"{part:g}"))
        at += wide
    return tag(
        "svg", *pieces, class_="gantt", viewBox=f"0 0 {COLUMNS} 1", preserveAspectRatio="none",
        role="img", aria_label=f"when {name} was under way",
    )  # fmt: skip


def _marked(number: int) -> Html:
    return tag("span", f"{number:,}", class_="bad") if number else Html("0")


def logged(title: str, data: ReportData) -> Html:
    """Lines written by the protocol's `log` steps."""
    digest = data.digest
    rows = ((at_time(line.at), line.message, code(line.path)) for line in digest.logged)
    first = f", the first {KEPT} of {digest.log_lines:,}" if digest.log_lines > KEPT else ""
    return section(
        "protocol-log", title,
        table(f"Log{first}", ["when (UTC)", "line", "step"], rows),
    )  # fmt: skip
