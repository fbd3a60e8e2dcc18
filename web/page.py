"""The report as one HTML page that needs no server: who reads it sees the run, and can check it."""

from .chapter_record import data, figures, files, versions
from .chapter_trouble import answers, doubts, failures, holes, stops
from .chapter_work import actions, done, logged, when
from .markup import Markup, code, facts, join, listed, paragraph, tag
from .material import Material
from .style import STYLE
from .words import count, duration, moment

CHAPTERS = (
    ("What was done", done), ("When", when), ("Figures", figures), ("Actions", actions),
    ("What failed, and how it was handled", failures), ("What was not known for a while", doubts),
    ("Holes", holes), ("Questions", answers), ("Stops and safe states", stops),
    ("What the protocol said", logged), ("Data", data), ("Files", files), ("Versions", versions),
)  # fmt: skip
POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'"


def page(material: Material) -> str:
    """The whole page."""
    chapters = [(title, chapter(title, material)) for title, chapter in CHAPTERS]
    present = [(title, made) for title, made in chapters if made]
    head = join([
        Markup('<meta charset="utf-8">'),
        Markup('<meta name="viewport" content="width=device-width,initial-scale=1">'),
        Markup(f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'),
        tag("title", f"{material.name}: {material.fate} ({material.folder.name})"),
        tag("style", Markup(STYLE)),
    ])  # fmt: skip
    body = tag("main", _heading(material), _contents(present), *(made for _, made in present))
    return f'<!doctype html>\n<html lang="en">{tag("head", head)}{tag("body", body)}</html>\n'


def _heading(material: Material) -> Markup:
    summary = str(material.inputs.protocol.get("summary", ""))
    return tag(
        "header",
        tag("h1", material.name),
        paragraph(tag("span", summary, class_="soft")) if summary else "",
        paragraph(tag("span", material.fate, class_=f"fate {material.fate}")),
        tag("p", verdict(material), class_="verdict"),
        _cautions(material),
        facts(_facts(material)),
    )


def verdict(material: Material) -> str:
    """The run's fate and what it left, in two or three sentences."""
    story = material.story
    finished = story.finished
    reason = f": {finished.reason}" if finished is not None and finished.reason else ""
    holes = count(story.hole_count, "hole") if story.hole_count else "no holes"
    said = {
        "succeeded": f"The run succeeded{reason}, with {holes}.",
        "failed": f"The run failed{reason}.",
        "aborted": f"The run was {reason[2:] or 'aborted'}.",
        "running": "The run goes on while this is written; what follows is its journal so far.",
        "interrupted": "The run was interrupted: its engine has gone without a last word. "
        f"`labrun resume {material.folder.name}` goes on with it.",
    }.get(material.fate, f"The run is {material.fate}{reason}.")
    return f"{said} {_sums(material)}"


def _sums(material: Material) -> str:
    story = material.story
    sent, failed, again = story.total("sent"), story.total("failed"), story.total("again")
    if not sent:
        return "No action was sent to any device."
    told = [f"{count(sent, 'action')} {'was' if sent == 1 else 'were'} sent"]
    told.append(f"{failed:,} of them failed" if failed else "none of them failed")
    if again:
        told.append(f"{again:,} repeated an earlier one")
    return ", ".join(told) + "."


def _cautions(material: Material) -> Markup:
    found = [*_doubtful(material)]
    return tag("div", listed(found), class_="caution", role="note") if found else Markup()


def _doubtful(material: Material) -> list[str]:
    story, inventory = material.story, material.inventory
    found = []
    if story.damage:
        found.append(
            f"The journal cannot be read to its end, so this report is not whole: {story.damage}"
        )
    if inventory.changed:
        names = _names([file.path for file in inventory.changed])
        found.append(f"Changed since the run wrote it: {names}.")
    if inventory.missing:
        names = _names([file.path for file in inventory.missing])
        found.append(f"Written by the run, and gone now: {names}.")
    if material.stale_tables:
        names = _names(material.stale_tables)
        found.append(f"Does not hold the rows that the journal holds: {names}.")
    last = {safe.device: safe for safe in story.safe}
    unsafe = [f"{name} ({safe.message})" for name, safe in last.items() if not safe.confirmed]
    if unsafe:
        found.append(f"Did not confirm its safe state: {_names(unsafe)}. Go and look.")
    found += [fault[0].upper() + fault[1:] + "." for fault in material.inputs.faults]
    return found


def _names(names: list[str], shown: int = 6) -> str:
    more = f" and {len(names) - shown:,} more" if len(names) > shown else ""
    return ", ".join(names[:shown]) + more


def _facts(material: Material) -> list[tuple[str, object]]:
    story, spans = material.story, material.story.spans
    rows: list[tuple[str, object]] = [("Run", code(material.folder.name))]
    if material.inputs.simulated:
        rows.append(("Devices", "simulated: no real device was touched"))
    if story.began:
        rows += [("Began (UTC)", moment(story.began)), ("Last record (UTC)", moment(story.ended))]
        rows.append(("Time spent running", duration(spans.running_s - spans.paused_s)))
    if len(spans.lives) > 1:
        told = f"{len(spans.lives) - 1}, {duration(spans.away_s)} in all"
        rows.append(("Interruptions", told))
    if spans.paused_s:
        rows.append(("Paused", duration(spans.paused_s)))
    for name, loop in list(story.loops.items())[:3]:
        rows.append(
            (
                f"Iterations of {name.removeprefix('main/')}",
                f"{loop.total:,}, {loop.failed:,} left out",
            )
        )
    if story.started is not None:
        rows.append(("Made by", f"labrun {story.started.labrun}, Python {story.started.python}"))
    return rows


def _contents(present: list[tuple[str, Markup]]) -> Markup:
    links = (tag("li", tag("a", title, href=f"#{anchor(title)}")) for title, _ in present)
    return tag("nav", tag("ul", *links), aria_label="Contents")


def anchor(title: str) -> str:
    """`what-was-done`: where a chapter is linked to."""
    return "-".join("".join(c for c in title.lower() if c.isalnum() or c == " ").split())
