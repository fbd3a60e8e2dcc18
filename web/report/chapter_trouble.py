"""Report chapters on failures and interventions, and how they were handled."""

from ...schemas.journal import SafeState
from .counts import KEPT
from .formatting import count
from .html import (
    BREAK,
    Html,
    at_time,
    code,
    folded,
    join,
    label,
    listed,
    paragraph,
    section,
    table,
    tag,
)
from .incident import Group, Groups, Incident
from .report_data import ReportData

PLACES_SHOWN = 60


def failures(title: str, data: ReportData) -> Html:
    """Each kind of failure: when, where, why, and what happened next."""
    found = data.digest.outcomes.failures
    if not found:
        return section(_FAILURES, title, paragraph("No action failed or was cancelled."))
    failed = sum(group.count for group in found if group.first.failed) + found.others
    cancelled = len(found) - failed
    told = f"{count(failed, 'action')} failed" if failed else "No action failed"
    told += f", {cancelled:,} {'was' if cancelled == 1 else 'were'} cancelled" if cancelled else ""
    outcomes = ", ".join(f"{number:,} {words}" for words, number in found.outcomes().items())
    told += f". Of these, {outcomes}. Identical failures are listed once, with their number."
    header = ["when (UTC)", "action", "where in the protocol", "why", "what happened next"]
    return section(
        _FAILURES, title, paragraph(told),
        table("Failed and cancelled actions", header, map(_failure_row, found)),
        _others(found),
    )  # fmt: skip


_FAILURES = "what-failed-and-how-it-was-handled"


def _failure_row(group: Group) -> tuple[object, ...]:
    first = group.first
    word = tag("span", first.error, class_="bad" if first.failed else "warn")
    why = join([word, f": {first.message}" if first.message else "", _fate(first)])
    return _times(group), label(first.label), _places(group), why, listed(first.followed)


def _fate(incident: Incident) -> Html:
    words = {"no": "the action had not happened", "yes": "the action had happened nevertheless"}
    told = words.get(incident.happened)
    return join([BREAK, tag("span", told, class_="soft")]) if told else Html()


def _times(group: Group) -> Html:
    if group.count == 1:
        return at_time(group.first.at)
    return join([
        tag("strong", f"{group.count:,} times"), BREAK, at_time(group.first.at), BREAK,
        "until ", at_time(group.last_at),
    ])  # fmt: skip


def _places(group: Group) -> Html:
    if group.count == 1:
        return _place(group.first)
    places = [_place(incident) for incident in group.examples[1:]]
    left = group.count - len(group.examples)
    more = [f"and {left:,} more"] if left else []
    inside = folded(
        f"and {group.count - 1:,} more", tag("ul", *(tag("li", p) for p in [*places, *more]))
    )
    return join([_place(group.first), inside])


def _place(incident: Incident) -> Html:
    return join(
        [code(incident.path), " ", tag("span", f"attempt {incident.attempt}", class_="when")]
    )


def _others(groups: Groups) -> Html:
    if not groups.others:
        return Html()
    return paragraph(
        f"And {count(groups.others, 'incident')} of other kinds; all are in the journal."
    )


def doubts(title: str, data: ReportData) -> Html:
    """Goals whose outcome was unknown, and how each was resolved."""
    rows = (
        (
            _times(group), label(group.first.label), _places(group), _doubt(group.first),
            listed(group.first.followed),
        )
        for group in data.digest.outcomes.doubts
    )  # fmt: skip
    header = [
        "sent or ended (UTC)",
        "action",
        "where in the protocol",
        "why",
        "how it was resolved",
    ]
    found = table("Outcomes that were unknown for a while", header, rows)
    if not found:
        found = paragraph("The outcome of every action was known at once.")
    return section("unknown-outcomes", title, found, _others(data.digest.outcomes.doubts))


def _doubt(incident: Incident) -> str:
    return f"{incident.error}: {incident.doubt}" if incident.error else incident.doubt


def holes(title: str, data: ReportData) -> Html:
    """Iterations that were left out (holes), by reason."""
    digest = data.digest
    if not digest.hole_count:
        told = "No iteration was left out." if digest.loops else ""
        return section("holes", title, paragraph(told) if told else "")
    rows = []
    for found in filter(lambda holes: holes.count, digest.holes.values()):
        shown = join([code(place) for place in found.places[:PLACES_SHOWN]], ", ")
        left = found.count - min(len(found.places), PLACES_SHOWN)
        rows.append(
            (
                f"{found.count:,}",
                found.message,
                join([shown, f" and {left:,} more" if left else ""]),
            )
        )
    rows += [("1", hole.message, code(path)) for path, hole in digest.stands.items()]
    return section(
        "holes", title, table("Iterations that were left out", ["holes", "why", "where"], rows)
    )


def answers(title: str, data: ReportData) -> Html:
    """Questions to the operator, and who answered what."""
    digest = data.digest
    rows = [
        (
            at_time(asking.at), asking.text, ", ".join(asking.choices),
            tag("strong", asking.choice) if asking.choice else "not answered",
            asking.by, at_time(asking.answered_at) if asking.answered_at else "", code(asking.path),
        )
        for asking in digest.asked
    ]  # fmt: skip
    header = ["asked (UTC)", "question", "choices", "answer", "by", "answered (UTC)", "where"]
    more = f", the first {KEPT} of {digest.questions:,}" if digest.questions > KEPT else ""
    return section("questions", title, table(f"Questions to the operator{more}", header, rows))


def stops(title: str, data: ReportData) -> Html:
    """Pauses, aborts, and whether the devices confirmed their safe state."""
    digest = data.digest
    controls = ((at_time(control.at), control.verb, control.by) for control in digest.controls)
    return section(
        "stops-and-safe-states", title,
        table("Pauses, resumptions and aborts", ["when (UTC)", "what", "by"], controls),
        table(
            "Safe states", ["when (UTC)", "device", "confirmed", "message"],
            map(_safe_row, digest.safe),
        ),
        table(
            "Devices that may have lost their state; settings made by a point were repeated",
            ["when (UTC)", "device", "why"],
            ((at_time(touched.at), touched.device, touched.reason) for touched in digest.touched),
        ),
    )  # fmt: skip


def _safe_row(safe: SafeState) -> tuple[object, ...]:
    said = tag("span", "yes", class_="good") if safe.confirmed else tag("span", "no", class_="bad")
    return at_time(safe.at), safe.device, said, safe.message
