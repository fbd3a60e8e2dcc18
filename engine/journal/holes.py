"""The holes of a run: iterations that failed and were left out, and how they are measured again.

The iteration at which the run itself failed is one, too, where a `once` action in it failed after it had
happened: a plain resume does not send it again, and would fail at it for ever. Outside any loop it is the
step of that action.
"""

from collections.abc import Iterable, Sequence

from ...schemas import journal as j
from .course import Course, Hole
from .journal import Records
from .past import upwards

SHOWN = 12


class UnknownHole(ValueError):
    """A key that belongs to no hole; the text says which there are."""


def holes_of(records: Iterable[j.JournalRecord]) -> list[Hole]:
    """Holes that can be measured again; of a hole with holes inside, only itself."""
    course = Course()
    for record in records:
        course.take(record)
    return list(course.holes_by_path.values())


def redo(records: Records | Sequence[j.JournalRecord], keys: Sequence[str], by: str) -> j.Redo:
    """The record that asks for these holes, by key or path, all if none is named; raises UnknownHole."""
    holes = holes_of(records)
    unknown = set(keys) - {name for hole in holes for name in (hole.key, hole.path)}
    if unknown or not holes:
        known = ", ".join(hole.key for hole in holes[:SHOWN])
        more = f" and {len(holes) - SHOWN:,} more" if len(holes) > SHOWN else ""
        what = f"no hole {min(unknown)!r}" if unknown else "no holes"
        raise UnknownHole(f"the run has {what}" + (f"; it has {known}{more}" if known else ""))
    chosen = [hole.path for hole in holes if not keys or {hole.key, hole.path} & set(keys)]
    ended = {f"{r.loop}/{r.key}" for r in records if isinstance(r, j.IterationEnded)}
    around = dict.fromkeys(
        path for hole in chosen for path in upwards(hole) if path in ended and path != hole
    )
    number = 2 + sum(isinstance(record, j.Redo) for record in records)
    return j.Redo(by=by, pass_number=number, iterations=chosen, reopened=list(around))
