"""The holes of a run: iterations that failed and were left out, and how they are measured again.

The iteration at which the run itself failed is one, too, where a `once` action in it failed after it had
happened: a plain resume does not send it again, and would fail at it for ever.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ...schemas import journal as j
from .course import MAIN, split_goal_id
from .journal import Records
from .past import upwards

SHOWN = 12


@dataclass(frozen=True, slots=True)
class Hole:
    """One iteration that failed; `key` is that of its row (`A/0,0` within another iteration)."""

    path: str
    key: str
    message: str


class UnknownHole(ValueError):
    """A key that belongs to no hole; the text says which there are."""


def holes_of(records: Iterable[j.JournalRecord]) -> list[Hole]:
    """Holes that can be measured again; of a hole with holes inside, only itself."""
    found: dict[str, Hole] = {}
    shots: dict[str, str] = {}
    failed: dict[str, str] = {}
    ended: dict[str, Hole] = {}
    for record in records:
        match record:
            case j.GoalSent() if record.effect == "once" and record.id.partition("/")[2].startswith(
                MAIN
            ):
                shots[record.id] = split_goal_id(record.id)[0]
                failed.pop(shots[record.id], None)
            case j.GoalEnded() if record.id in shots:
                path = shots.pop(record.id)
                if record.error is not None and record.error.happened == "yes":
                    failed[path] = record.error.message
            case j.LoopEnded(fate="failed", loop=loop):
                for path in [path for path in failed if path.startswith(f"{loop}/")]:
                    key = path.removeprefix(f"{loop}/").partition("/")[0]
                    ended.setdefault(path, Hole(f"{loop}/{key}", key, failed[path]))
            case j.Finished(fate="failed"):
                for path, hole in ended.items():
                    if record.detail.startswith(f"{path}: "):
                        found[hole.path] = hole
                ended.clear()
            case j.IterationEnded(loop=loop) if loop.startswith(MAIN):
                path = f"{loop}/{record.key}"
                found.pop(path, None)
                for inner in [inner for inner in failed if inner.startswith(f"{path}/")]:
                    del failed[inner]
                if record.fate == "failed":
                    _drop_inside(found, path)
                    found[path] = Hole(path, record.row_key, record.message)
            case j.Redo():
                for path in record.iterations:
                    found.pop(path, None)
                    _drop_inside(found, path)
            case _:
                pass
    return list(found.values())


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


def _drop_inside(found: dict[str, Hole], path: str) -> None:
    for inner in [inner for inner in found if inner.startswith(f"{path}/")]:
        del found[inner]
