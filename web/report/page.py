"""The report as one HTML page that needs no server: it shows the run and how to verify it."""

from ...schemas.journal import ended_as
from .chapter_record import data, figures, files, snapshots, versions
from .chapter_trouble import answers, doubts, failures, holes, stops
from .chapter_words import in_words
from .chapter_work import actions, logged, provenance, when
from .formatting import count
from .html import Html, join, listed, paragraph, tag
from .report_data import ReportData
from .style import STYLE

CHAPTERS = (
    ("Figures", figures), ("What was done", in_words),
    ("What failed, and how it was handled", failures), ("Holes", holes),
    ("Unknown outcomes", doubts), ("Questions", answers), ("Stops and safe states", stops),
    ("Snapshots", snapshots), ("Data", data), ("Protocol log", logged), ("Provenance", provenance),
    ("When", when), ("Actions", actions), ("Files", files), ("Versions", versions),
)  # fmt: skip
"""What a reader wants to see first comes first; ids, boots and hashes come last."""
OPENING = ("Figures", "What was done")
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
    first = [made for title, made in present if title in OPENING]
    rest = [(title, made) for title, made in present if title not in OPENING]
    body = tag("main", _heading(data), *first, _contents(rest), *(made for _, made in rest))
    return f'<!doctype html>\n<html lang="en">{tag("head", head)}{tag("body", body)}</html>\n'


def _heading(data: ReportData) -> Html:
    summary = str(data.inputs.protocol.get("summary", ""))
    return tag(
        "header",
        tag("h1", data.name),
        paragraph(tag("span", summary, class_="soft")) if summary else "",
        paragraph(
            tag("span", ended_as(data.fate, data.digest.hole_count), class_=f"fate {data.fate}")
        ),
        tag("p", verdict(data), class_="verdict"),
        _cautions(data),
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
    points = digest.points.words(digest.hole_count) if digest.points is not None else ""
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


def _contents(present: list[tuple[str, Html]]) -> Html:
    links = (tag("li", tag("a", title, href=f"#{anchor(title)}")) for title, _ in present)
    return tag("nav", tag("ul", *links), aria_label="Contents")


def anchor(title: str) -> str:
    """`what-was-done`: the anchor of a chapter."""
    return "-".join("".join(c for c in title.lower() if c.isalnum() or c == " ").split())
