"""What a journal tells, gathered for a reader in one pass and in room that does not grow with it."""

from itertools import pairwise
from pathlib import Path

from ..engine.journal import JournalFault, read_records
from ..engine.run_folder import JOURNAL
from ..schemas import journal as j
from .goal import Sent
from .rows_told import RowsTold
from .spans import Life
from .tally import KEPT, Asking, Boot, Counted, Deed, Holes, Story
from .words import seconds_between


def read_story(folder: Path, *, live: bool = False) -> Story:
    """Go through the journal once; where it is damaged, the story ends with the last whole record."""
    story = Story()
    try:
        for record in read_records(folder / JOURNAL):
            _read(story, record)
    except JournalFault as fault:
        story.damage = str(fault)
    except UnicodeError:  # bytes that are no text: the chain cannot even be computed
        story.damage = f"{folder / JOURNAL}: record {story.records + 1} is not text"
    story.handling.close(finished=story.finished is not None, live=live)
    return story


def _read(story: Story, record: j.JournalRecord) -> None:
    story.records, story.last_hash = record.n, record.hash
    if isinstance(record, j.Resumed):
        _resumed(story, record)
    elif not story.spans.lives:
        story.spans.lives.append(Life(1, record.at, record.at, getattr(record, "labrun", "")))
    life = story.spans.lives[-1]
    life.ended = record.at
    match record:
        case j.GoalSent():
            _sent(story, story.handling.sent(record), life)
        case j.GoalEnded():
            _ended(story, record, story.handling.ended(record))
        case j.IterationEnded():
            _iteration(story, record)
        case j.Turned():
            story.handling.turned(record)
        case j.StepEnded() if record.message:
            story.log_lines += 1
            if len(story.logged) < KEPT:
                story.logged.append(record)
        case _:
            _read_rarer(story, record, life)


def _read_rarer(story: Story, record: j.JournalRecord, life: Life) -> None:
    match record:
        case j.Started():
            story.started = record
            story.files.update(record.files)
        case j.Changed():
            _changed(story, record)
        case j.Asked():
            _asked(story, record)
        case j.Answered():
            _answered(story, record)
        case j.Control():
            _control(story, record)
        case j.SafeState():
            story.safe.append(record)
        case j.Touched():
            story.touched.append(record)
        case j.Finished():
            story.finished = record
            life.fate, life.reason = record.fate, record.reason
            life.under_way = len(story.handling.under_way)
            story.spans.go_on(record.at, "the end of the run")
            story.handling.run_ended(record)
        case _:
            pass


def _resumed(story: Story, record: j.Resumed) -> None:
    if story.spans.lives:
        last = story.spans.lives[-1]
        last.under_way = len(story.handling.under_way)
        story.spans.go_on(last.ended, "the end of its engine")
    story.handling.engine_gone()
    story.finished = None
    number = len(story.spans.lives) + 1
    story.spans.lives.append(Life(number, record.at, record.at, record.labrun, torn=record.torn))


def _sent(story: Story, goal: Sent, life: Life) -> None:
    life.goals += 1
    deed = story.deeds.setdefault(goal.label, Deed())
    deed.sent += 1
    deed.again += goal.attempt > 1
    boots = story.boots.setdefault(goal.record.device, [])
    if not boots or boots[-1].boot != goal.record.boot:
        boots.append(Boot(goal.record.boot, goal.record.ledger, goal.record.at))


def _ended(story: Story, record: j.GoalEnded, goal: Sent | None) -> None:
    story.files.update(record.files)
    if goal is None:
        return
    story.writers.update(dict.fromkeys(record.files, goal.label))
    deed = story.deeds[goal.label]
    if record.state == "SUCCEEDED":
        deed.succeeded += 1
    elif record.state == "CANCELED":
        deed.cancelled += 1
    else:
        deed.failed += 1
    if goal.life != story.handling.life:
        return  # how long nobody ran the run says nothing of the action
    took_s = seconds_between(goal.record.at, record.at)
    deed.timed += 1
    deed.seconds += took_s
    deed.longest_s = max(deed.longest_s, took_s)


def _iteration(story: Story, record: j.IterationEnded) -> None:
    story.handling.iteration(record)
    _gather_inner(story, record)
    counted = story.loops.setdefault(record.loop, Counted())
    if record.fate == "succeeded":
        counted.succeeded += 1
    elif record.fate == "skipped":
        counted.skipped += 1
    else:
        counted.failed += 1
        _hole(story, record)
    if record.file and record.row is not None:
        story.tables.setdefault(record.file, RowsTold()).add(record)


def _gather_inner(story: Story, record: j.IterationEnded) -> None:
    """Loops inside this iteration are over, too: they are counted as one over all iterations."""
    prefix = f"{record.loop}/{record.key}/"
    for path in [path for path in story.loops if path.startswith(prefix)]:
        inner = story.loops.pop(path)
        name = f"{record.loop}/*/{path.removeprefix(prefix)}"
        held = story.loops.setdefault(name, Counted())
        held.succeeded += inner.succeeded
        held.failed += inner.failed
        held.skipped += inner.skipped


def _hole(story: Story, record: j.IterationEnded) -> None:
    place = f"{record.loop}/{record.key}"
    reason = record.message.replace(f"{place}/", "")
    holes = story.holes.get(reason)
    if holes is None:
        reason = reason if len(story.holes) < KEPT else "other reasons"
        holes = story.holes.setdefault(reason, Holes(reason))
    holes.count += 1
    story.holes_of[place] = reason
    if len(holes.places) < KEPT:
        holes.places.append(place)


def _changed(story: Story, record: j.Changed) -> None:
    """The run goes on with something else: iterations that are done again no longer count."""
    story.changes.append(record)
    for place in record.reopened:
        counted = story.loops.get(place.rpartition("/")[0], Counted())
        reason = story.holes_of.pop(place, None)
        if reason is None:
            counted.succeeded -= 1
        else:
            counted.failed -= 1
            holes = story.holes[reason]
            holes.count -= 1
            holes.places = [other for other in holes.places if other != place]


def _asked(story: Story, record: j.Asked) -> None:
    story.handling.asked(record)
    story.questions += 1
    asking = Asking(record.at, record.path, record.text, record.choices)
    story.unheard[record.path] = asking
    if len(story.asked) < KEPT:
        story.asked.append(asking)


def _answered(story: Story, record: j.Answered) -> None:
    story.handling.answered(record)
    asking = story.unheard.pop(record.path, None)
    if asking is not None:
        asking.choice, asking.by, asking.answered_at = record.choice, record.by, record.at


def _control(story: Story, record: j.Control) -> None:
    story.controls.append(record)
    if record.verb == "pause":
        story.spans.pause(record.at, record.by)
    else:
        story.spans.go_on(record.at, f"{record.verb} by {record.by}")
    if record.verb.startswith("abort"):
        story.handling.aborted_by = record.by


def interruptions(story: Story) -> list[tuple[Life, Life]]:
    """Each engine with the one that took over from it."""
    return list(pairwise(story.spans.lives))
