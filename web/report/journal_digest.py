"""Contents of a journal, collected in one pass, in memory that does not grow with the journal."""

from contextlib import suppress
from itertools import pairwise
from pathlib import Path

from pydantic import ValidationError

from ...engine.journal.course import MAIN, split_goal_id
from ...engine.journal.history import superseded
from ...engine.journal.journal import JournalFault, read_records
from ...engine.journal.past import without_passes
from ...engine.run.folder import JOURNAL
from ...schemas import journal as j
from .counts import KEPT, Asking, Boot, Counted, Deed, Holes, JournalDigest
from .formatting import seconds_between
from .rows_hash import RowsHash
from .spans import EngineSpan


def read_digest(folder: Path, *, live: bool = False) -> JournalDigest:
    """Read the journal once; if it is damaged, the digest ends with the last complete record."""
    digest = JournalDigest()
    digest.superseded = superseded(_reopenings(folder / JOURNAL))
    try:
        for record in read_records(folder / JOURNAL):
            _read(digest, record)
    except JournalFault as fault:
        digest.damage = str(fault)
    digest.outcomes.close(live=live)
    return digest


def _reopenings(journal: Path) -> list[j.JournalRecord]:
    """The records that say which iterations count no more: they come after those."""
    found: list[j.JournalRecord] = []
    with suppress(OSError), journal.open("rb") as lines:
        for line in lines:
            if b'"redo"' in line or b'"changed"' in line:
                with suppress(ValidationError):
                    found.append(j.RECORD.validate_json(line))
    return found


def _read(digest: JournalDigest, record: j.JournalRecord) -> None:
    if isinstance(record, j.Resumed):
        _resumed(digest, record)
    elif not digest.spans.lives:
        digest.spans.lives.append(
            EngineSpan(1, record.at, record.at, getattr(record, "labrun", ""))
        )
    life = digest.spans.lives[-1]
    if not isinstance(record, j.Redo | j.Changed):  # a resume writes these before its own record
        life.goes_on(record.at)
    match record:
        case j.GoalSent():
            digest.outcomes.sent(record)
            _sent(digest, record, life)
        case j.GoalEnded():
            _ended(digest, record)
            digest.outcomes.ended(record)
        case j.IterationEnded():
            _iteration(digest, record)
        case j.Turned():
            digest.outcomes.turned(record)
        case j.StepEnded() if record.message:
            digest.log_lines += 1
            if len(digest.logged) < KEPT:
                digest.logged.append(record)
        case _:
            _read_rarer(digest, record, life)
    digest.take(record)


def _read_rarer(digest: JournalDigest, record: j.JournalRecord, life: EngineSpan) -> None:
    match record:
        case j.Started():
            digest.files.update(record.files)
        case j.Planned() if record.loop.startswith(MAIN):
            digest.plans[record.loop] = record.total
        case j.Asked():
            _asked(digest, record)
        case j.Answered():
            _answered(digest, record)
        case j.Control():
            _control(digest, record)
        case j.SafeState():
            digest.safe.append(record)
        case j.Touched():
            digest.touched.append(record)
        case j.Finished():
            life.fate, life.reason = record.fate, record.reason
            life.under_way = len(digest.under_way)
            digest.spans.go_on(record.at, "the end of the run")
            digest.outcomes.run_ended(record)
        case _:
            pass


def _resumed(digest: JournalDigest, record: j.Resumed) -> None:
    if digest.spans.lives:
        last = digest.spans.lives[-1]
        last.under_way = len(digest.under_way)
        digest.spans.go_on(last.ended, "the end of its engine")
        digest.spans.earlier_s += last.seconds
    digest.outcomes.engine_gone()
    number = len(digest.spans.lives) + 1
    digest.spans.lives.append(
        EngineSpan(number, record.at, record.at, record.labrun, torn=record.torn)
    )


def _sent(digest: JournalDigest, record: j.GoalSent, life: EngineSpan) -> None:
    life.goals += 1
    deed = digest.deeds.setdefault(record.label, Deed())
    deed.sent += 1
    deed.again += split_goal_id(record.id)[1] > 1
    boots = digest.boots.setdefault(record.device, [])
    if not boots or boots[-1].boot != record.boot:
        boots.append(Boot(record.boot, record.ledger, record.at))


def _ended(digest: JournalDigest, record: j.GoalEnded) -> None:
    digest.files.update(record.files)
    goal = digest.under_way.get(record.id)
    if goal is None:
        return
    digest.writers.update(dict.fromkeys(record.files, goal.record.label))
    deed = digest.deeds[goal.record.label]
    if record.state == "SUCCEEDED":
        deed.succeeded += 1
    elif record.state == "CANCELED":
        deed.cancelled += 1
    else:
        deed.failed += 1
    if goal.session != digest.session:
        return  # the time without an engine says nothing about the action
    took_s = seconds_between(goal.record.at, record.at)
    deed.timed += 1
    deed.seconds += took_s
    deed.longest_s = max(deed.longest_s, took_s)
    ended_s = digest.spans.earlier_s + digest.spans.lives[-1].seconds
    digest.gantt.add(goal.record.label, ended_s - took_s, ended_s)


def _iteration(digest: JournalDigest, record: j.IterationEnded) -> None:
    is_over = digest.superseded(record)
    digest.outcomes.iteration(record, is_over=is_over)
    _gather_inner(digest, record)
    if is_over:
        return
    counted = digest.loops.setdefault(without_passes(record.loop), Counted())
    if record.fate == "succeeded":
        counted.succeeded += 1
    elif record.fate == "skipped":
        counted.skipped += 1
    else:
        counted.failed += 1
        _hole(digest, record)
    if record.file and record.row is not None:
        digest.tables.setdefault(record.file, RowsHash()).add(record)


def _gather_inner(digest: JournalDigest, record: j.IterationEnded) -> None:
    """Loops inside this iteration have ended too: they are counted together over all iterations."""
    loop = without_passes(record.loop)
    prefix = f"{loop}/{record.key}/"
    for path in [path for path in digest.loops if path.startswith(prefix)]:
        inner = digest.loops.pop(path)
        name = f"{loop}/*/{path.removeprefix(prefix)}"
        held = digest.loops.setdefault(name, Counted())
        held.succeeded += inner.succeeded
        held.failed += inner.failed
        held.skipped += inner.skipped


def _hole(digest: JournalDigest, record: j.IterationEnded) -> None:
    place = f"{record.loop}/{record.key}"
    reason = record.message.replace(f"{place}/", "")
    holes = digest.holes.get(reason)
    if holes is None:
        reason = reason if len(digest.holes) < KEPT else "other reasons"
        holes = digest.holes.setdefault(reason, Holes(reason))
    holes.count += 1
    if len(holes.places) < KEPT:
        holes.places.append(place)


def _asked(digest: JournalDigest, record: j.Asked) -> None:
    digest.outcomes.asked(record)
    digest.questions += 1
    asking = Asking(record.at, record.path, record.text, record.choices)
    digest.unheard[record.path] = asking
    if len(digest.asked) < KEPT:
        digest.asked.append(asking)


def _answered(digest: JournalDigest, record: j.Answered) -> None:
    digest.outcomes.answered(record)
    asking = digest.unheard.pop(record.path, None)
    if asking is not None:
        asking.choice, asking.by, asking.answered_at = record.choice, record.by, record.at


def _control(digest: JournalDigest, record: j.Control) -> None:
    digest.controls.append(record)
    if record.verb == "pause":
        digest.spans.pause(record.at, record.by)
    else:
        digest.spans.go_on(record.at, f"{record.verb} by {record.by}")


def interruptions(digest: JournalDigest) -> list[tuple[EngineSpan, EngineSpan]]:
    """Each engine session with the one that followed it."""
    return list(pairwise(digest.spans.lives))
