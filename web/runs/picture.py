"""The state of a run from its journal: steps, iterations, actions under way, questions, log."""

from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from ...engine.journal.course import Course, split_goal_id
from ...engine.journal.past import without_passes
from ...schemas import journal as j
from ..local.clock import since_1970
from ..models.runs import Fate, NodeState, PointState, Status
from .counts import CODE, FATES, End, NodeCount, Table, worst_of
from .log import Log
from .outline import Found, Outline, Step, ancestors
from .passed import passed
from .places import Items

MOST_TIMES = 2000
"""At most this many durations are kept of one action in one run."""


@dataclass(slots=True)
class Changed:
    """The contents of a patch."""

    nodes: set[str] = field(default_factory=set)
    points: set[tuple[str, str, int]] = field(default_factory=set)
    lines: list[int] = field(default_factory=list)
    head: bool = False

    def __bool__(self) -> bool:
        return bool(self.head or self.nodes or self.points or self.lines)


class Picture(Course):
    """Takes records one by one; gives what has changed since the last call."""

    def __init__(self, journal: Path, outline: Outline | None) -> None:
        super().__init__()
        self.outline = outline
        self.log = Log(journal)
        self.nodes: dict[str, NodeCount] = defaultdict(NodeCount)
        self.tables: dict[tuple[str, str], Table] = {}
        self.times: dict[str, list[float]] = defaultdict(list)
        self.files: dict[str, tuple[str, str, str]] = {}
        """File -> (loop, within, key) of its iteration."""
        self.changed = Changed()
        self.retries = 0
        self.now = 0.0
        self._amiss: dict[str, str] = {}
        self._items: dict[str, Items] = {}
        self._passed: tuple[tuple[int, int, bool], dict[str, Status]] | None = None
        self._told_passed: dict[str, Status] = {}

    # --- what is told

    def items(self, loop: str) -> Items | None:
        """The items of a loop by its pattern, computed once."""
        if loop not in self._items:
            step = self.outline.steps.get(loop) if self.outline is not None else None
            if step is None:
                return None
            self._items[loop] = Items(step)
        return self._items[loop]

    def table(self, loop: str, within: str) -> Table:
        """The iterations of a loop; created empty on the first call."""
        key = (loop, within)
        if key not in self.tables:
            items = self.items(loop)
            self.tables[key] = Table(loop, within, total=items.total if items else None)
        return self.tables[key]

    def outer_tables(self) -> list[Table]:
        """Those of loops that are not in a loop, in the order of their beginning."""
        return [table for table in self.tables.values() if "*" not in table.loop]

    @property
    def fate(self) -> Fate:
        """How it ended; otherwise `running` or `paused`, as far as the journal shows."""
        if self.finished is not None:
            return self.finished.fate
        return "paused" if self.paused else "running"

    @property
    def holes(self) -> dict[tuple[str, str, str], str]:
        """(loop, within, key) of iterations to be measured again -> their paths in the journal."""
        found: dict[tuple[str, str, str], str] = {}
        for path in self.holes_by_path:
            loop_path, _, key = path.rpartition("/")
            place = self._find(loop_path)
            if place is not None:
                found[place.step.told.path, place.within, key] = path
        return found

    def states(self) -> dict[str, NodeState]:
        """The states of all steps that have begun or been passed."""
        states = {path: NodeState(status=status) for path, status in self.passed().items()}
        return states | {path: count.state() for path, count in self.nodes.items()}

    def passed(self) -> dict[str, Status]:
        """Steps that the run has passed without a record."""
        if self.outline is None:
            return {}
        good = self.finished is not None and self.fate == "succeeded"
        rounds = {loop for (loop, _), table in self.tables.items() if table.counts.get("ok")}
        asked = (len(self.nodes), len(rounds), good)
        if self._passed is None or self._passed[0] != asked:
            found = passed(self.outline, self.nodes.keys(), rounds.__contains__, good)
            self._passed = (asked, found)
        return self._passed[1]

    def take_changes(self) -> tuple[dict[str, NodeState], list[PointState], list[int]]:
        """New states of steps, iterations, and log lines since the last call."""
        changed, self.changed = self.changed, Changed()
        nodes = {path: self.nodes[path].state() for path in changed.nodes}
        if changed.nodes or self.finished is not None:
            before, self._told_passed = self._told_passed, self.passed()
            news = self._told_passed.items() - before.items()
            nodes |= {path: NodeState(status=status) for path, status in news}
        points = [self.tables[loop, within].point(slot) for loop, within, slot in changed.points]
        return nodes, points, changed.lines

    # --- records

    def read(self, offset: int, record: j.JournalRecord) -> None:
        """Learn from one record, which begins at this offset of the journal."""
        self.changed.head = True
        self.now = since_1970(record.at)
        if self.log.take(offset, record):
            self.changed.lines.append(len(self.log) - 1)
        match record:
            case j.GoalSent():
                self._sent(record, offset)
            case j.GoalEnded():
                self._ended(record, offset)
            case j.IterationEnded():
                self._iteration(record, offset)
            case j.StepEnded():
                with self._counting(record.path, offset) as count:
                    count.end(FATES[record.fate], None, record.message)
            case j.Asked():
                with self._counting(record.path, offset) as count:
                    count.running = 1
            case j.Answered():
                with self._counting(record.path, offset) as count:
                    count.running = 0
                    count.end("ok", None, f"{record.choice} ({record.by})")
            case j.LoopEnded():
                self._loop(record)
            case j.Changed():
                for path in (*record.reopened, *self.stands):
                    self._reopen(path)
            case j.Redo():
                self._redo(record)
            case j.Resumed():
                self._cut()
                for path in self.stands:
                    self._reopen(path)
            case j.Control():
                self._cut()
            case j.Finished():
                self.close()
            case _:
                pass
        self.take(record)
        if isinstance(record, j.Finished):
            self._fail_where_it_stands()

    def _fail_where_it_stands(self) -> None:
        """The iteration at which the run failed is one of its holes, if a resume cannot go on from there."""
        for path, hole in self.stands.items():
            loop, _, key = path.rpartition("/")
            found = self._find(loop)
            table = self.table(found.step.told.path, found.within) if found is not None else None
            slot = table.slots.get(key) if table is not None else None
            if table is not None and slot is not None and not table.ended[slot]:
                table.end(slot, table.index[slot], "failed", self.now, hole.message)
                self._point(table, slot)

    def _redo(self, record: j.Redo) -> None:
        """Holes are measured again, with all that is in them."""
        for path in record.reopened:
            self._reopen(path)
        for path in record.iterations:
            found, key = self._reopen(path)
            within = f"{found.within}/{key}".lstrip("/") if found is not None else None
            for table in self.tables.values():
                if within is not None and f"{table.within}/".startswith(f"{within}/"):
                    for slot in range(len(table.keys)):
                        self._reopen_slot(table, slot)

    def _reopen(self, path: str) -> tuple[Found | None, str]:
        loop_path, _, key = path.rpartition("/")
        found = self._find(loop_path)
        if found is not None:
            table = self.table(found.step.told.path, found.within)
            if key in table.slots:
                self._reopen_slot(table, table.slots[key])
        return found, key

    def _reopen_slot(self, table: Table, slot: int) -> None:
        table.reopen(slot)
        self._point(table, slot)

    def _sent(self, record: j.GoalSent, offset: int) -> None:
        path, attempt = split_goal_id(record.id)
        again = attempt > 1 and record.id not in self.under_way
        self.retries += again
        with self._counting(path, offset, tries=again) as count:
            count.running += 1
            count.retrying += again
            count.retries += again

    def _ended(self, record: j.GoalEnded, offset: int) -> None:
        goal = self.under_way.get(record.id)
        if goal is None:
            return
        took = round(self.now - since_1970(goal.record.at), 4)
        times = self.times[goal.record.label]
        if record.state == "SUCCEEDED" and len(times) < MOST_TIMES:
            times.append(took)
        found = self._find(goal.path)
        if found is not None:
            loop, key = found.innermost
            for file in record.files:
                self.files[file] = (loop or "", found.around, key or "")
        error = record.error
        words = f"{error.name}: {error.message}".strip(": ") if error is not None else ""
        step = without_passes(goal.path)
        with self._counting(goal.path, offset) as count:
            count.running = max(0, count.running - 1)
            count.retrying = max(0, count.retrying - (goal.attempt > 1))
            counted = count.end(_status(record), took, words, instead_of=self._amiss.pop(step, ""))
        if counted != "ok":
            self._amiss[step] = counted  # until it is tried or measured again

    def _iteration(self, record: j.IterationEnded, offset: int) -> None:
        found = self._find(record.loop)
        if found is None:
            return
        table = self.table(found.step.told.path, found.within)
        slot = table.touch(record.key, offset, self.now)
        if table.ended[slot]:
            return  # repeated after a change: the first end and the reopening are what counts
        table.end(slot, record.index, FATES[record.fate], self.now, _without_path(record))
        self._point(table, slot)
        self._ran(found.step)

    def _loop(self, record: j.LoopEnded) -> None:
        found = self._find(record.loop)
        if found is not None:
            table = self.table(found.step.told.path, found.within)
            if table.total is None or record.fate == "succeeded":
                table.total = record.total
            table.counted = self.nodes[found.step.told.path].end(
                FATES[record.fate], None, "", instead_of=table.counted
            )
            self._ran(found.step)

    def close(self) -> None:
        """Nothing is under way any more: the engine has ended."""
        for goal in self.under_way.values():
            found = self._find(goal.path)
            if found is not None:
                self.changed.nodes.add(found.step.told.path)
        for count in self.nodes.values():
            count.running = count.retrying = 0
        if self.under_way or self.open_questions:
            self.changed.head = True
        self.under_way.clear()
        for table in self.tables.values():
            table.current = None
            for slot in table.under_way():  # cut off: unfinished
                table.status[slot] = CODE["cancelled"]
                self._point(table, slot)

    # --- the way to steps and iterations

    def _find(self, path: str) -> Found | None:
        return self.outline.find(path) if self.outline is not None else None

    @contextmanager
    def _counting(self, path: str, offset: int, *, tries: bool = False) -> Iterator[NodeCount]:
        """The count of a step in which something happens; a spare one for a step that is not known."""
        found = self._find(path)
        if found is None:
            yield NodeCount()
            return
        within = ""
        for loop, key in found.loops:
            table = self.table(loop, within)
            known = table.is_running(key)
            slot = table.touch(key, offset, self.now)
            table.tries[slot] += tries
            if not known or tries:
                self._point(table, slot)
            within = f"{within}/{key}" if within else key
        yield self.nodes[found.step.told.path]
        self._ran(found.step)

    def _point(self, table: Table, slot: int) -> None:
        self.changed.points.add((table.loop, table.within, slot))

    def _ran(self, step: Step) -> None:
        """A step's state has changed, and with it those of the steps around it."""
        assert self.outline is not None
        path = step.told.path
        self.changed.nodes.add(path)
        for above in ancestors(self.outline.steps, path):
            count = self.nodes[above]
            below = [self.nodes[one] for one in self._children(above) if one in self.nodes]
            count.running = sum(one.running for one in below)
            count.retrying = sum(one.retrying for one in below)
            ends: list[End] = [one.last for one in below if one.last]
            if ends and not self.outline.steps[above].is_loop and not count.running:
                count.last = worst_of(ends)  # a group's state follows from its steps
            self.changed.nodes.add(above)

    def _children(self, path: str) -> list[str]:
        assert self.outline is not None
        step = self.outline.steps[path]
        found = []
        for one in (*step.below.values(), *step.last.values()):
            found += [one.told.path] if one.told.path != path else self._paths(one)
        for alternative in step.alternatives:
            found += [one.told.path for one in alternative.values()]
        return found

    def _paths(self, branch: Step) -> list[str]:
        return [one.told.path for one in branch.below.values()]

    def _cut(self) -> None:
        for table in self.tables.values():
            table.cut()


def _without_path(record: j.IterationEnded) -> str:
    """What went wrong in an iteration, without where in it: the row beside it says that."""
    if record.message.startswith(f"{record.loop}/{record.key}/"):
        return record.message.partition(": ")[2]
    return record.message


def _status(record: j.GoalEnded) -> Status:
    if record.state == "SUCCEEDED":
        return "ok"
    if record.state == "CANCELED":
        return "cancelled"
    unknown = record.error is not None and record.error.happened == "unknown"
    return "unknown" if unknown else "failed"
