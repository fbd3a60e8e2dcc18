"""The holes of a run: iterations that failed and were left out, and how they are measured again.

The iteration at which the run itself failed is one, too, where a `once` action in it failed after it had
happened: a plain resume does not send it again, and would fail at it for ever. Outside any loop it is the
step of that action.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ...schemas import journal as j
from .course import MAIN, split_goal_id
from .journal import Records
from .past import PASS, upwards

SHOWN = 12


@dataclass(frozen=True, slots=True)
class Hole:
    """One iteration that failed; `key` is that of its row (`A/0,0` within another iteration).

    Outside any loop, one step and its own path without `main/`.
    """

    path: str
    key: str
    message: str


class UnknownHole(ValueError):
    """A key that belongs to no hole; the text says which there are."""


class Standing:
    """Where a run failed for good, from records one by one; `holes` by path.

    An iteration (or a step outside any) in which a `once` action failed after it had happened: a resume
    fails there again.
    """

    def __init__(self) -> None:
        self.holes: dict[str, Hole] = {}
        self._shots: dict[str, str] = {}
        self._failed: dict[str, str] = {}
        self._ended: dict[str, Hole] = {}

    def take(self, record: j.Record) -> None:
        """Learn from the next record."""
        match record:
            case j.GoalSent() if record.effect == "once" and record.id.partition("/")[2].startswith(
                MAIN
            ):
                self._shots[record.id] = split_goal_id(record.id)[0]
                self._failed.pop(self._shots[record.id], None)
            case j.GoalEnded() if record.id in self._shots:
                path = self._shots.pop(record.id)
                if record.error is not None and record.error.happened == "yes":
                    self._failed[path] = record.error.message
            case j.LoopEnded(fate="failed", loop=loop):
                for path in [path for path in self._failed if path.startswith(f"{loop}/")]:
                    key = path.removeprefix(f"{loop}/").partition("/")[0]
                    self._ended.setdefault(path, Hole(f"{loop}/{key}", key, self._failed[path]))
            case j.Finished(fate="failed"):
                for path, message in self._failed.items():
                    if record.detail.startswith(f"{path}: "):
                        hole = self._ended.get(path) or _step(path, message)
                        self.holes[hole.path] = hole
                self._ended.clear()
            case j.IterationEnded():
                self._left(f"{record.loop}/{record.key}")
            case j.Redo():
                for path in record.iterations:
                    self._left(path)
            case _:
                pass

    def _left(self, path: str) -> None:
        """An iteration is over, or entered anew: what failed in it no longer counts."""
        for known in (self._failed, self.holes):
            for inner in [one for one in known if f"{one}/".startswith(f"{path}/")]:
                del known[inner]


def _step(path: str, message: str) -> Hole:
    """The step of an action, whichever pass it was."""
    step = path.partition(f"/{PASS}")[0]
    return Hole(step, step.removeprefix(MAIN), message)


def holes_of(records: Iterable[j.JournalRecord]) -> list[Hole]:
    """Holes that can be measured again; of a hole with holes inside, only itself."""
    found: dict[str, Hole] = {}
    standing = Standing()
    for record in records:
        standing.take(record)
        match record:
            case j.IterationEnded(loop=loop) if loop.startswith(MAIN):
                path = f"{loop}/{record.key}"
                found.pop(path, None)
                if record.fate == "failed":
                    _drop_inside(found, path)
                    found[path] = Hole(path, record.row_key, record.message)
            case j.Redo():
                for path in record.iterations:
                    found.pop(path, None)
                    _drop_inside(found, path)
            case _:
                pass
    return [*found.values(), *standing.holes.values()]


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
