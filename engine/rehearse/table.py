"""A rehearsal as lines of text."""

import math
from collections.abc import Iterator

from ...schemas.journal import ended_as
from ..journal.gantt import marks
from .totals import COLUMNS, Totals

SHOWN = 12
WIDTH = 60
"""Characters of the Gantt chart."""
MARKS = 6
BLOCKS = " ▁▂▃▄▅▆▇█"


def lines(totals: Totals, real_s: float) -> Iterator[str]:
    """Line by line: the whole, the parts, the work, and what would go wrong."""
    yield f"The run takes {duration(totals.lasts_s)} and {_ends(totals)}. (Rehearsed in {real_s:.1f} s.)"
    yield ""
    yield from _parts(totals)
    yield ""
    yield from _work(totals)
    yield ""
    yield from gantt(totals)
    yield from _wrong(totals)
    strange = [f"{d} is played by {who}" for d, who in totals.players.items() if "stand-in" in who]
    if strange:
        yield ""
        yield "; ".join(strange) + ": typical times, the simplest answers, no simulated faults."


def _ends(totals: Totals) -> str:
    reason = f": {totals.reason}" if totals.reason else ""
    return f"{ended_as(totals.fate, totals.holes)}{reason}"


def _parts(totals: Totals) -> Iterator[str]:
    width = max([len(part.name) for part in totals.parts] or [4])
    yield f"{'part':<{width}}  {'starts at':>10}  {'takes':>10}  {'per point':>9}  actions"
    for part in totals.parts:
        each = duration(part.takes_s / part.iterations) if part.iterations else ""
        yield (
            f"{part.name:<{width}}  {duration(part.begins_s):>10}  {duration(part.takes_s):>10}  "
            f"{each:>9}  {part.goals:,}"
            + (f" in {_count(part.iterations, 'point')}" if each else "")
        )


def _work(totals: Totals) -> Iterator[str]:
    width = max([len(label) for label in totals.actions] or [6])
    yield f"{'action':<{width}}  {'times':>7}  {'total':>10}"
    for label, count in totals.actions.items():
        once = "  once each: never repeated without asking" if totals.once.get(label) else ""
        yield f"{label:<{width}}  {count:>7,}  {duration(totals.seconds[label]):>10}{once}"
    for device, mm in totals.path_mm.items():
        yield f"{device} travels {mm / 1000:,.2f} m"


def gantt(totals: Totals) -> Iterator[str]:
    """What each device does when: a line for each action, the fuller the more of the time it is under way."""
    (from_s, to_s), each = totals.shown_s, COLUMNS // WIDTH
    if not totals.gantt:
        if totals.actions:
            yield f"No action is under way from {duration(from_s)} to {duration(to_s)}."
            yield ""
        return
    width = max(len("when"), *(len(label) for label in totals.gantt))
    axis = ""
    for moment, words in marks(from_s, to_s - from_s, MARKS):
        at = int(WIDTH * (moment - from_s) / (to_s - from_s))
        axis += f"{'' if not axis else ' '}".ljust(at - len(axis)) + words
    yield f"{'when':<{width}}  {axis}"
    for label, row in totals.gantt.items():
        parts = (sum(row[n : n + each]) / each for n in range(0, COLUMNS, each))
        blocks = (BLOCKS[math.ceil(part * (len(BLOCKS) - 1))] for part in parts)
        yield f"{label:<{width}}  {''.join(blocks)}".rstrip()
    yield ""


def _wrong(totals: Totals) -> Iterator[str]:
    for label in totals.unreached:
        yield f"{label} cannot fail here: no step that runs does it."
    if totals.unreached and not (totals.troubles or totals.questions or totals.slow):
        return
    if not (totals.troubles or totals.questions or totals.slow):
        if not totals.reason:  # the first line has said it
            yield "Nothing goes wrong. Inject faults to see what would happen: --fail ROLE.ACTION:0.05"
        return
    yield "What goes wrong:"
    for trouble in totals.troubles[:SHOWN]:
        yield (
            f"  {trouble.action}: {trouble.error}, {_count(trouble.count, 'time')}, first after "
            f"{duration(trouble.first_at_s)} at {trouble.first_path}: {trouble.message}"
        )
    if totals.sent_again:
        yield f"  {_count(totals.sent_again, 'goal')} sent again by retry"
    if totals.holes or totals.points.left:
        yield f"  points: {totals.points.words(totals.holes)}"
    for label, (took, limit) in totals.slow.items():
        yield f"  {label} took up to {duration(took)} of its timeout of {duration(limit)}"
    for text in totals.questions[:SHOWN]:
        yield f"  a person is asked: {text}"
    if len(totals.questions) > SHOWN:
        yield f"  and {len(totals.questions) - SHOWN} more questions"


def _count(number: int, word: str) -> str:
    return f"{number:,} {word}{'' if number == 1 else 's'}"


def duration(seconds: float) -> str:
    """`4 h 27 min`, `3 min 20 s`, `12.3 s`."""
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest:02} s"
    return f"{minutes // 60} h {minutes % 60:02} min"
