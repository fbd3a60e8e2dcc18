"""The report as one HTML page that needs no server: it shows the run and how to verify it."""

from ...schemas.journal import ended_as
from .chapter_record import data, figures, files, versions
from .chapter_trouble import answers, doubts, failures, holes, stops
from .chapter_work import actions, done, logged, when
from .formatting import count, duration, moment
from .html import Html, code, facts, join, listed, paragraph, tag
from .report_data import ReportData
from .style import STYLE

CHAPTERS = (
    ("What was done", done), ("When", when), ("Figures", figures), ("Actions", actions),
    ("What failed, and how it was handled", failures), ("Unknown outcomes", doubts),
    ("Holes", holes), ("Questions", answers), ("Stops and safe states", stops),
    ("Protocol log", logged), ("Data", data), ("Files", files), ("Versions", versions),
)  # fmt: skip
POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'"


def page(data: ReportData) -> str:
    """The whole page."""
    chapters = [(title, chapter(title, data)) for title, chapter in CHAPTERS]
    present = [(title, made) for title, made in chapters if made]
    head = join([
        Html('<meta charset="utf-8">'),
        Html('<meta name="viewport" content="width=device-width,initial-scale=1">'),
        Html(f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'),
        tag("title", f"{data.name}: {data.fate} ({data.folder.name})"),
        tag("style", Html(STYLE)),
    ])  # fmt: skip
    body = tag("main", _heading(data), _contents(present), *(made for _, made in present))
    return f'<!doctype html>\n<html lang="en">{tag("head", head)}{tag("body", body)}</html>\n'


def _heading(data: ReportData) -> Html:
    summary = str(data.inputs.protocol.get("summary", ""))
    return tag(
        "header",
        tag("h1", data.name),
        paragraph(tag("span", summary, class_="soft")) if summary else "",
        paragraph(tag("span", data.fate, class_=f"fate {data.fate}")),
        tag("p", verdict(data), class_="verdict"),
        _cautions(data),
        facts(_facts(data)),
    )


def verdict(data: ReportData) -> str:
    """The run's outcome in two or three sentences."""
    digest = data.digest
    finished = digest.finished
    reason = f": {finished.reason}" if finished is not None and finished.reason else ""
    how = ended_as(data.fate, digest.hole_count)
    but = reason.replace(":", ", but", 1) + ("" if digest.hole_count else ", with no holes")
    said = {
        "succeeded": f"The run {how}{but}.",
        "failed": f"The run failed{reason}.",
        "aborted": f"The run was {reason[2:] or 'aborted'}.",
        "running": "The run is still going; this report covers its journal so far.",
        "interrupted": "The run was interrupted: its engine ended without a last record. "
        f"`labrun resume {data.folder.name}` continues it.",
    }.get(data.fate, f"The run is {data.fate}{reason}.")
    points = finished.points.words() if finished is not None and finished.points else ""
    return f"{said} {f'Points: {points}. ' if points else ''}{_sums(data)}"


def _sums(data: ReportData) -> str:
    digest = data.digest
    sent, failed, again = digest.total("sent"), digest.total("failed"), digest.total("again")
    if not sent:
        return "No action was sent to any device."
    told = [f"{count(sent, 'action')} {'was' if sent == 1 else 'were'} sent"]
    told.append(f"{failed:,} of them failed" if failed else "none of them failed")
    if again:
        told.append(f"{again:,} repeated an earlier action")
    return ", ".join(told) + "."


def _cautions(data: ReportData) -> Html:
    found = [*_doubtful(data)]
    return tag("div", listed(found), class_="caution", role="note") if found else Html()


def _doubtful(data: ReportData) -> list[str]:
    digest, inventory = data.digest, data.inventory
    found = []
    if digest.damage:
        found.append(
            f"The journal cannot be read to its end, so this report is incomplete: {digest.damage}"
        )
    if inventory.changed:
        names = _names([file.path for file in inventory.changed])
        found.append(f"Changed since the run wrote it: {names}.")
    if inventory.missing:
        names = _names([file.path for file in inventory.missing])
        found.append(f"Written by the run, now missing: {names}.")
    if data.stale_tables:
        names = _names(data.stale_tables)
        found.append(f"Does not match the journal's rows: {names}.")
    last = {safe.device: safe for safe in digest.safe}
    unsafe = [f"{name} ({safe.message})" for name, safe in last.items() if not safe.confirmed]
    if unsafe:
        found.append(f"Safe state not confirmed: {_names(unsafe)}. Go and check.")
    found += [fault[0].upper() + fault[1:] + "." for fault in data.inputs.faults]
    return found


def _names(names: list[str], shown: int = 6) -> str:
    more = f" and {len(names) - shown:,} more" if len(names) > shown else ""
    return ", ".join(names[:shown]) + more


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


def _contents(present: list[tuple[str, Html]]) -> Html:
    links = (tag("li", tag("a", title, href=f"#{anchor(title)}")) for title, _ in present)
    return tag("nav", tag("ul", *links), aria_label="Contents")


def anchor(title: str) -> str:
    """`what-was-done`: the anchor of a chapter."""
    return "-".join("".join(c for c in title.lower() if c.isalnum() or c == " ").split())
