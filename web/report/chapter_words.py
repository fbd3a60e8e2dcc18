"""What was done, in one paragraph: by the protocol's own words, and how the run went."""

from collections.abc import Iterator

from ...engine.run.folder import FolderFault, newest_copies
from ...engine.runner.change import check_copy
from ...engine.views.english import lower_first, upper_first
from ...engine.views.forecast import outlook
from ...engine.views.words.item import Item
from ...engine.views.words.steps import sentences
from .formatting import count, duration, moment, value
from .html import Html, paragraph, section
from .report_data import ReportData

PROTOCOL_SHOWN = 1500
NAMED = 4


def in_words(title: str, data: ReportData) -> Html:
    """One paragraph that could stand in a paper."""
    told = " ".join([*_when(data), *_procedure(data), *_asked(data), *_course(data)])
    return section("what-was-done", title, paragraph(told))


def _when(data: ReportData) -> Iterator[str]:
    digest = data.digest
    if not digest.began:
        return
    began, ended = moment(digest.began), moment(digest.ended)
    until = ended.removeprefix(began[:11]) if ended.startswith(began[:11]) else ended
    where = ", on simulated devices: no real device was used" if data.inputs.simulated else ""
    yield f"{data.name} ran from {began} to {until} (UTC){where}."
    spans = digest.spans
    more = []
    if len(spans.lives) > 1:
        stops = count(len(spans.lives) - 1, "interruption")
        more.append(f"{stops} ({duration(spans.away_s)} without an engine)")
    if spans.paused_s:
        more.append(f"pauses of {duration(spans.paused_s)}")
    takes = f"It worked for {duration(spans.running_s - spans.paused_s)}"
    yield f"{takes}, with {' and '.join(more)}." if more else f"{takes}."
    if spans.set_back_s >= 1:
        yield f"Meanwhile the computer's clock was set back by {duration(spans.set_back_s)}."


def _procedure(data: ReportData) -> Iterator[str]:
    """The protocol's sentences as one; none if its copy can no longer be checked."""
    try:
        checked, _ = check_copy(newest_copies(data.folder, data.digest))
    except (FolderFault, OSError, KeyError, TypeError):
        return
    if not checked.ok or checked.protocol is None:
        return
    items = sentences(outlook(checked), checked.protocol.steps, ("steps",))
    words = ". ".join(upper_first(_flat(item)) for item in items)
    if words:
        yield f"{words[:PROTOCOL_SHOWN]} …" if len(words) > PROTOCOL_SHOWN else f"{words}."


def _flat(item: Item) -> str:
    """What is done, without what is done if it fails, which is told where something has failed."""
    text = item.text.partition(". ")[0].rstrip(".:")
    if not item.below:
        return text
    return f"{text}: {'; '.join(lower_first(_flat(inner)) for inner in item.below)}"


def _asked(data: ReportData) -> Iterator[str]:
    started, inputs = data.digest.started, data.inputs
    given = [
        f"{name} = {value(told)}"
        for name, told in (started.params if started is not None else {}).items()
        if inputs.given(name)
    ]
    if given:
        yield f"Set for this run: {', '.join(given)}."


def _course(data: ReportData) -> Iterator[str]:
    digest = data.digest
    if digest.points is not None and (words := digest.points.words(digest.hole_count)):
        yield f"Points: {words}."
    for redo in digest.redone:
        yield f"{redo.by} had {count(len(redo.iterations), 'hole')} measured again."
    sent = sorted(digest.deeds.items(), key=lambda deed: -deed[1].sent)
    if sent:
        parts = [f"{label} {count(deed.sent, 'time')}" for label, deed in sent[:NAMED]]
        more = f", and {count(len(sent) - NAMED, 'other action')}" if len(sent) > NAMED else ""
        yield f"Sent were {', '.join(parts)}{more}."
