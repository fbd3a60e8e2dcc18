"""Chapters of the report on what did not go by itself, and what was done about it."""

from ..schemas.journal import SafeState
from .incident import Group, Groups, Incident
from .markup import (
    BREAK,
    Markup,
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
from .material import Material
from .tally import KEPT
from .words import count

PLACES_SHOWN = 60


def failures(title: str, material: Material) -> Markup:
    """Each kind of failure: when, where, why, and what followed."""
    found = material.story.handling.failures
    if not found:
        return section(_FAILURES, title, paragraph("No action failed, and none was cancelled."))
    failed = sum(group.count for group in found if group.first.failed) + found.others
    cancelled = len(found) - failed
    told = f"{count(failed, 'action')} failed" if failed else "No action failed"
    told += f", {cancelled:,} {'was' if cancelled == 1 else 'were'} cancelled" if cancelled else ""
    outcomes = ", ".join(f"{number:,} {words}" for words, number in found.outcomes().items())
    told += f". Of these, {outcomes}. What is alike is told once, with how often it happened."
    header = ["when (UTC)", "action", "where in the protocol", "why", "what followed"]
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


def _fate(incident: Incident) -> Markup:
    words = {"no": "it had not happened", "yes": "it had happened all the same"}
    told = words.get(incident.happened)
    return join([BREAK, tag("span", told, class_="soft")]) if told else Markup()


def _times(group: Group) -> Markup:
    if group.count == 1:
        return at_time(group.first.at)
    return join([
        tag("strong", f"{group.count:,} times"), BREAK, at_time(group.first.at), BREAK,
        "until ", at_time(group.last_at),
    ])  # fmt: skip


def _places(group: Group) -> Markup:
    if group.count == 1:
        return _place(group.first)
    places = [_place(incident) for incident in group.examples[1:]]
    left = group.count - len(group.examples)
    more = [f"and {left:,} more"] if left else []
    inside = folded(
        f"and {group.count - 1:,} more", tag("ul", *(tag("li", p) for p in [*places, *more]))
    )
    return join([_place(group.first), inside])


def _place(incident: Incident) -> Markup:
    return join(
        [code(incident.path), " ", tag("span", f"attempt {incident.attempt}", class_="when")]
    )


def _others(groups: Groups) -> Markup:
    if not groups.others:
        return Markup()
    return paragraph(
        f"And {count(groups.others, 'incident')} of further kinds; the journal has them all."
    )


def doubts(title: str, material: Material) -> Markup:
    """Goals whose fate was not known, and how each was settled."""
    rows = (
        (
            _times(group), label(group.first.label), _places(group), _doubt(group.first),
            listed(group.first.followed),
        )
        for group in material.story.handling.doubts
    )  # fmt: skip
    header = ["sent or ended (UTC)", "action", "where in the protocol", "why", "how it was settled"]
    found = table("Fates that were not known for a while", header, rows)
    if not found:
        found = paragraph("Of every action that was sent, it was known at once how it ended.")
    return section(
        "what-was-not-known-for-a-while", title, found, _others(material.story.handling.doubts)
    )


def _doubt(incident: Incident) -> str:
    return f"{incident.error}: {incident.doubt}" if incident.error else incident.doubt


def holes(title: str, material: Material) -> Markup:
    """Iterations that were left out, by reason."""
    story = material.story
    if not story.hole_count:
        told = "No iteration was left out." if story.loops else ""
        return section("holes", title, paragraph(told) if told else "")
    rows = []
    for found in filter(lambda holes: holes.count, story.holes.values()):
        shown = join([code(place) for place in found.places[:PLACES_SHOWN]], ", ")
        left = found.count - min(len(found.places), PLACES_SHOWN)
        rows.append(
            (
                f"{found.count:,}",
                found.message,
                join([shown, f" and {left:,} more" if left else ""]),
            )
        )
    return section(
        "holes", title, table("Iterations that were left out", ["holes", "why", "where"], rows)
    )


def answers(title: str, material: Material) -> Markup:
    """Questions to people, and who answered what."""
    story = material.story
    rows = [
        (
            at_time(asking.at), asking.text, ", ".join(asking.choices),
            tag("strong", asking.choice) if asking.choice else "not answered",
            asking.by, at_time(asking.answered_at) if asking.answered_at else "", code(asking.path),
        )
        for asking in story.asked
    ]  # fmt: skip
    header = ["asked (UTC)", "question", "choices", "answer", "by", "answered (UTC)", "where"]
    more = f", the first {KEPT} of {story.questions:,}" if story.questions > KEPT else ""
    return section("questions", title, table(f"Questions to people{more}", header, rows))


def stops(title: str, material: Material) -> Markup:
    """Pauses, aborts, and whether the devices confirmed their safe state."""
    story = material.story
    controls = ((at_time(control.at), control.verb, control.by) for control in story.controls)
    return section(
        "stops-and-safe-states", title,
        table("Pauses, continuations and aborts", ["when (UTC)", "what", "by"], controls),
        table(
            "Safe states", ["when (UTC)", "device", "confirmed", "in its own words"],
            map(_safe_row, story.safe),
        ),
        table(
            "Devices whose state may have been lost; what a point had set was set again",
            ["when (UTC)", "device", "why"],
            ((at_time(touched.at), touched.device, touched.reason) for touched in story.touched),
        ),
    )  # fmt: skip


def _safe_row(safe: SafeState) -> tuple[object, ...]:
    said = tag("span", "yes", class_="good") if safe.confirmed else tag("span", "no", class_="bad")
    return at_time(safe.at), safe.device, said, safe.message
