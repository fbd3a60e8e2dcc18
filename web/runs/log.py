"""The log of a run: which records are its lines; the text of a line is made on request."""

from array import array
from pathlib import Path

from ...engine.journal.course import split_goal_id
from ...engine.journal.journal import read_at
from ...schemas import journal as j
from ..models.runs import LogLine, LogWindow
from ..report.formatting import duration, seconds_between
from .outline import Outline

MOST_SEARCHED = 200_000
PROBLEM = 1
LINES = (
    j.Started, j.Resumed, j.Changed, j.Redo, j.Phase, j.GoalEnded, j.Turned, j.Asked, j.Answered,
    j.LoopEnded, j.Control, j.SafeState, j.Touched, j.Again, j.Finished,
)  # fmt: skip


class Log:
    """Positions of the log's lines in the journal; 30 bytes per line."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.n = array("q")
        self._offset = array("q")
        self._other = array("q")
        self._flags = bytearray()
        self._device = array("h")
        self._devices: dict[str, int] = {}
        self._sent: dict[str, tuple[int, str]] = {}
        """Id of a goal under way -> the offset of its sending, and its device."""

    def __len__(self) -> int:
        return len(self.n)

    def take(self, offset: int, record: j.JournalRecord) -> bool:
        """Note a record if it is a line of the log; returns whether it is."""
        if isinstance(record, j.GoalSent):
            self._sent[record.id] = (offset, record.device)
            return False
        if not is_line(record):
            return False
        if isinstance(record, j.GoalEnded):
            sent_offset, device = self._sent.pop(record.id, (-1, ""))
        else:
            sent_offset, device = -1, getattr(record, "device", "")
        self.n.append(record.n)
        self._offset.append(offset)
        self._other.append(sent_offset)
        self._flags.append(PROBLEM if is_problem(record) else 0)
        self._device.append(self._devices.setdefault(device, len(self._devices)))
        return True

    def window(
        self, outline: Outline | None, after: int | None, before: int | None, limit: int,
        *, problems: bool, device: str | None, find: str,
    ) -> LogWindow:  # fmt: skip
        """A window of lines: the last ones, or those next to a line's number."""
        wanted = [
            i
            for i in range(len(self.n))
            if (not problems or self._flags[i] & PROBLEM)
            and (device is None or self._device[i] == self._devices.get(device, -1))
        ]
        if find:
            words = find.casefold()
            told = self.lines(wanted[-MOST_SEARCHED:], outline)
            fits = {line.n for line in told if words in line.text.casefold()}
            wanted = [i for i in wanted if self.n[i] in fits]
        if after is not None:
            start = next((k for k, i in enumerate(wanted) if self.n[i] > after), len(wanted))
            chosen = range(start, min(len(wanted), start + limit))
        else:
            end = len(wanted)
            if before is not None:
                end = next((k for k, i in enumerate(wanted) if self.n[i] >= before), end)
            chosen = range(max(0, end - limit), end)
        return LogWindow(
            lines=self.lines([wanted[k] for k in chosen], outline), total=len(wanted),
            more_before=chosen.start > 0,
        )  # fmt: skip

    def lines(self, which: list[int], outline: Outline | None) -> list[LogLine]:
        """Lines by their positions."""
        records = read_at(self._path, [self._offset[i] for i in which])
        with_sent = [i for i in which if self._other[i] >= 0]
        sendings = read_at(self._path, [self._other[i] for i in with_sent])
        sent = {
            i: one
            for i, one in zip(with_sent, sendings, strict=True)
            if isinstance(one, j.GoalSent)
        }
        return [
            line_of(record, sent.get(i), outline) for i, record in zip(which, records, strict=True)
        ]


def is_line(record: j.JournalRecord) -> bool:
    """True for a record that is a line of the log."""
    match record:
        case j.StepEnded():
            return bool(record.message)
        case j.IterationEnded():
            return record.fate == "failed"
        case _:
            return isinstance(record, LINES)


def is_problem(record: j.JournalRecord) -> bool:
    """True for a failure, or a possible one."""
    match record:
        case j.GoalEnded():
            return record.state != "SUCCEEDED"
        case j.StepEnded():
            return record.fate in ("failed", "unknown")
        case j.IterationEnded() | j.LoopEnded() | j.Finished():
            return record.fate != "succeeded"
        case j.SafeState():
            return not record.confirmed
        case j.Control():
            return record.verb.startswith("abort")
        case _:
            return isinstance(record, j.Turned | j.Touched | j.Resumed)


def line_of(record: j.JournalRecord, sent: j.GoalSent | None, outline: Outline | None) -> LogLine:
    """One record as a line, with its step, its point and its position in the YAML."""
    path = path_of(record)
    found = outline.find(path) if outline is not None and path else None
    loop, key = found.innermost if found is not None else (None, None)
    if isinstance(record, j.IterationEnded) and found is not None:
        loop, key = found.step.told.path, record.key
    return LogLine(
        n=record.n, at=record.at, level="problem" if is_problem(record) else "info",
        kind=record.kind, text=_text(record, sent), device=getattr(sent or record, "device", None),
        path=path, node=found.step.told.path if found is not None else None,
        loop=loop, key=key, line=found.step.told.line if found is not None else None,
    )  # fmt: skip


def path_of(record: j.JournalRecord) -> str:
    """The path of the step that it is about; empty for the run as a whole."""
    if isinstance(record, j.GoalSent | j.GoalEnded):
        return split_goal_id(record.id)[0]
    return getattr(record, "path", "") or getattr(record, "loop", "")


def _text(record: j.JournalRecord, sent: j.GoalSent | None) -> str:
    match record:
        case j.Started():
            return f"started with labrun {record.labrun}"
        case j.Resumed():
            by = f" by {record.by}" if record.by else ""
            return f"resumed{by} (resume {record.count}) with labrun {record.labrun}"
        case j.Changed():
            return f"continues with a changed protocol ({record.folder})"
        case j.Redo():
            number = len(record.iterations)
            what = f"{number:,} holes are" if number > 1 else "a hole is"
            return f"{what} measured again (pass {record.pass_number}), for {record.by}"
        case j.Phase():
            name = record.phase.partition(":")[0]
            return "the protocol" if name == "main" else name
        case j.GoalEnded():
            return _goal(record, sent)
        case j.StepEnded():
            return record.message
        case j.Turned():
            error = record.error or {}
            why = f" after {error.get('name')}: {error.get('message', '')}" if error else ""
            return f"turn {record.turn}{why}".rstrip(": ")
        case j.Asked():
            return f"? {record.text} [{'/'.join(record.choices)}]"
        case j.Answered():
            return f"answered {record.choice} by {record.by}"
        case j.IterationEnded():
            place, _, rest = record.message.partition(": ")
            why = rest if place.startswith(f"{record.loop}/") else record.message
            return f"{record.key}: {why or 'failed'} (a hole)"
        case j.LoopEnded():
            return (
                f"loop ended: {record.succeeded} ok, {record.failed} failed, "
                f"{record.skipped} skipped"
            )
        case j.Control():
            return f"{record.verb} by {record.by}"
        case j.SafeState():
            words = "safe state confirmed" if record.confirmed else "safe state NOT confirmed"
            return f"{record.device}: {words}" + _more(record.message)
        case j.Touched():
            return f"{record.device}: {record.reason}"
        case j.Again():
            return "the failed step is retried" + _more(record.by)
        case j.Finished():
            but = record.fate == "succeeded" and record.reason
            more = f", but {record.reason}" if but else _more(record.reason)
            return f"run {j.ended_as(record.fate, record.holes)}{more}"
        case _:
            return record.kind


def _goal(record: j.GoalEnded, sent: j.GoalSent | None) -> str:
    label, took = record.id, ""
    if sent is not None:
        _, attempt = split_goal_id(record.id)
        label = sent.label + (f" (try {attempt})" if attempt > 1 else "")
        took = f" {duration(seconds_between(sent.at, record.at))}"
    if record.state == "SUCCEEDED":
        return f"{label} ok{took}"
    error = record.error
    name = error.name if error is not None else record.state.lower()
    return f"{label} {name}{took}{_more(error.message if error is not None else '')}"


def _more(text: str) -> str:
    return f": {text}" if text else ""
