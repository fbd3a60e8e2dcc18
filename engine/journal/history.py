"""What has happened, as the journal says it: the memory of a run, living or resumed.

Recording is learning. `History.take` is the only way in: a living run takes each record as it writes
it, a resumed one takes them all from the disk, and both know the same.
"""

from collections import Counter, deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from ...schemas import journal as j
from ...schemas.messages import ledger_of
from .course import MAIN, Course, split_goal_id
from .journal import JournalFault, Records
from .past import Past, PastGoal, upwards

RESTARTED = "its server was restarted"
STRANGER = "another client held or stopped it in between"
LAPSED = (
    "no engine was in contact for as long as its lease: its server brought it to its safe state"
)
LOOKS = ".look"
"""What the path of a watch's readings ends with."""
STOPPED = "Stopped"
"""The error of a goal that a stop has cut or refused."""
ORDER_KEPT = 1000
WORK = frozenset(
    (j.IterationEnded, j.LoopEnded, j.StepEnded, j.Turned, j.Answered, j.Computed, j.Touched)
)
REFUSALS = ("no", "stop")


@dataclass(slots=True)
class InARow:
    """Goals that have set one thing of a device, with nothing between them that is done again.

    `path`: of the newest one; `first_n`, `path_n`, `last_n`: the first of all, and the first and last of it.
    """

    path: str
    first_n: int
    path_n: int
    last_n: int


@dataclass(slots=True)
class History(Course):
    """The run as a whole, its work by path (`past`), and its devices.

    `cleaned_up`: the engine session before the newest one had ended by
    itself. `touched`: device -> the record since which what steps had set on it may be lost.
    `marks`: the newest change that was seen in the ledger of a device. `ledger_n`: the record since
    which it has its present ledger, where the run has met more than one. `doubtful`: devices whose ledger
    was replaced or put back, as was this journal: what neither of them knows may have happened.
    """

    past: Past = field(default_factory=Past)
    resumed_n: int = 0
    cleaned_up: bool = False
    finals: int = 0
    main_at: str = ""
    """When its steps began for the first time."""
    ended: bool = False
    """The newest engine session has ended by itself, in whatever way."""
    order: dict[str, deque[str]] = field(default_factory=dict)
    epochs: dict[str, set[int]] = field(default_factory=dict)
    leased_n: dict[str, int] = field(default_factory=dict)
    lease_boots: dict[str, str] = field(default_factory=dict)
    ledger_n: dict[str, int] = field(default_factory=dict)
    put_back: bool = False
    doubtful: set[str] = field(default_factory=set)
    marks: dict[str, str] = field(default_factory=dict)
    touched: dict[str, int] = field(default_factory=dict)
    boots: dict[str, str] = field(default_factory=dict)
    once_n: int = 0
    """The newest `once` action that was sent, to any device."""
    in_a_row: dict[tuple[str, str], InARow] = field(default_factory=dict)
    """What was set of each device (device, what), and whether something has begun to replace it."""
    repeatable_n: int = 0
    """The newest goal of a step that may be done twice."""
    work_n: int = 0
    """The newest record that a changed protocol may be held against: not what a watch has read."""
    plans: dict[str, int | None] = field(default_factory=dict)
    """The outermost loops of the protocol that have begun -> how many iterations they have."""

    # --- learning

    def take(self, record: j.Record) -> None:
        """Learn what one record says, after all those before it."""
        match record:  # the frequent ones first: that a model is not of a class is slow to find
            case j.GoalSent():
                self._take_sent(record)
            case j.GoalEnded():
                self._take_ended(record)
            case j.Marked():
                self.marks[record.device] = record.mark
            case j.IterationEnded():
                self._take_iteration(record)
            case j.StepEnded():
                self.past.steps[record.path] = record
            case j.Resumed():
                self._take_resumed(record)
            case j.Again():
                self._spend()
            case j.Changed():
                self.past.changed = record
                self.in_a_row.clear()
            case j.Redo():
                self._take_redo(record)
            case j.Phase():
                if record.phase == "main":
                    self.main_at = self.main_at or record.at
                self.finals += record.phase.startswith("finally")
            case j.Expired():
                self._take_expired(record)
            case j.Planned() if record.loop.startswith(MAIN):
                self.plans[record.loop] = record.total
            case j.LoopEnded():  # for journals that say nothing of plans
                total = record.total if record.fate == "succeeded" else None
                self.plans.setdefault(record.loop, total)
            case j.Computed():
                self.past.computed[record.path] = record.value
            case j.Turned():
                self.past.turned[record.path] = record
            case j.Answered():
                self.past.answers[record.path] = record
            case j.Leased():
                self._take_leased(record)
            case j.SafeState() | j.Touched():
                self.touched[record.device] = record.n
            case j.Finished():
                self.ended = True
            case _:
                pass
        if type(record) in WORK:
            self.work_n = record.n
        Course.take(self, record)

    def _take_resumed(self, record: j.Resumed) -> None:
        self.resumed_n = record.n
        self.put_back = self.put_back or bool(record.put_back)
        self.cleaned_up, self.ended = self.ended, False
        if self.cleaned_up:
            self._spend()

    def _take_redo(self, record: j.Redo) -> None:
        """What was done in these iterations is no longer theirs."""
        self.in_a_row.clear()
        for path in record.iterations:
            loop, _, key = path.rpartition("/")
            self.past.forget(f"{path}/")
            self.past.iterations.get(loop, {}).pop(key, None)
            self.past.passes[path] = record.pass_number

    def _take_leased(self, record: j.Leased) -> None:
        device, before = record.device, self.lease_boots.get(record.device)
        other = before is not None and ledger_of(before) != ledger_of(record.boot)
        if other or not record.continues:
            self.epochs.pop(device, None)  # those of another ledger say nothing about these
            self.ledger_n[device] = record.n
        if self.put_back and (other or before is None or not record.continues):
            self.doubtful.add(device)
        self.epochs.setdefault(device, set()).add(record.epoch)
        self.leased_n[device] = record.n
        self.lease_boots[device] = record.boot
        self.marks[device] = record.mark

    def _take_sent(self, record: j.GoalSent) -> None:
        path, attempt = split_goal_id(record.id)
        if path.endswith(LOOKS):
            self.past.goals.pop(path, None)  # of what a watch reads, only the newest
        else:
            self.work_n = record.n
        self.past.goals.setdefault(path, {})[attempt] = PastGoal(record)
        self.boots[record.device] = record.boot
        if record.effect == "once":
            self.once_n = record.n
            self.order.setdefault(record.device, deque(maxlen=ORDER_KEPT)).append(record.id)
        elif path.startswith(MAIN) and not path.endswith((LOOKS, "/probe")):
            if record.sets:
                self._take_setting(record, path)
            self.repeatable_n = record.n
        if not path.startswith(MAIN):
            self.touched[record.device] = record.n

    def _take_setting(self, sent: j.GoalSent, path: str) -> None:
        what, n = (sent.device, sent.sets), sent.n
        row = self.in_a_row.get(what)
        if row is None or row.last_n != self.repeatable_n:
            row = self.in_a_row[what] = InARow(path, n, n, n)
        elif path != row.path:
            whole = row.last_n > self.touched.get(sent.device, 0)
            row.path, row.path_n, row.first_n = path, n, row.first_n if whole else n
        row.last_n = n

    def _take_ended(self, record: j.GoalEnded) -> None:
        path, attempt = split_goal_id(record.id)
        past = self.past.goal(path, attempt)
        if past is None:  # it outlived its iteration, which is over and forgotten
            return
        sent = past.sent
        if path.endswith("/probe") and self._has_lost(sent.device, record.result or {}):
            self.put_back = True
            self.doubtful |= self.leased_n.keys()
        self.work_n = self.work_n if path.endswith(LOOKS) else record.n
        cut = self._was_cut(record, sent)
        if sent.sets and record.state != "SUCCEEDED" and not cut:
            self.in_a_row.pop((sent.device, sent.sets), None)  # it may have replaced nothing
        # Asked about under a later lease: it may have ended right after it was sent.
        asked = sent.n < self.leased_n.get(sent.device, 0)
        self.past.goals[path][attempt] = replace(
            past, ended=record, state_n=sent.n if asked else record.n,
            spent=not past.expired and cut,
        )  # fmt: skip

    def _was_cut(self, ended: j.GoalEnded, sent: j.GoalSent) -> bool:
        """A stop, an abort or the death of the engine ended it: unfinished, and not a failure."""
        name = ended.error.name if ended.error is not None else ""
        lost = name == "Lost" and sent.n < self.resumed_n
        return ended.state == "CANCELED" or name == STOPPED or lost

    def _take_expired(self, record: j.Expired) -> None:
        path, attempt = split_goal_id(record.id)
        past = self.past.goal(path, attempt)
        if past is not None:
            self.past.goals[path][attempt] = replace(past, expired=True)

    def _take_iteration(self, record: j.IterationEnded) -> None:
        if self.past.comparing:
            self.past.gone_through.add(f"{record.loop}/{record.key}")
            return
        self.past.keep_settings(record.loop, f"{record.loop}/{record.key}/")
        self.past.forget(f"{record.loop}/{record.key}/")
        fates = self.past.iterations.setdefault(record.loop, {})
        fates[record.key] = record.fate
        if record.sets:
            self.past.sets.setdefault(record.loop, {}).update(record.sets)

    def _spend(self) -> None:
        """Close past failures: what failed has all its attempts again, under new numbers.

        The branch that a retried group or a fallback took is kept: what was done there is done. So
        are a person's answers, except to stop.
        """
        past = self.past
        past.begun_anew, past.spent_n = True, self.last_n
        self.in_a_row.clear()
        for device in self._cleaned_by_use():
            self.touched[device] = self.last_n + 1
        past.answers = {p: a for p, a in past.answers.items() if a.choice not in REFUSALS}
        for failed in [p for p, step in past.steps.items() if step.fate == "failed"]:
            for path in [p for p in past.computed if p.startswith(f"{failed}/")]:
                del past.computed[path]
        past.steps = {p: step for p, step in past.steps.items() if step.fate == "succeeded"}
        for path, tries in past.goals.items():
            past.goals[path] = {
                attempt: replace(goal, spent=goal.ended is not None and not goal.succeeded)
                for attempt, goal in tries.items()
            }

    def _cleaned_by_use(self) -> set[str]:
        """Devices that were used by the `finally` of a used protocol that had failed."""
        used = tuple(path[:-1] + "finally:" for path in self.past.turned if path.endswith("/e"))
        return {
            goal.sent.device
            for path, tries in self.past.goals.items()
            if path.startswith(used)
            for goal in tries.values()
        }

    def points(self) -> j.Points:
        """How far the run is: plan, measured, failed, left."""
        fates = Counter(
            fate for loop in self.plans for fate in self.past.iterations.get(loop, {}).values()
        )
        totals = list(self.plans.values())
        plan = None if None in totals else sum(total or 0 for total in totals)
        stood = self.stood(self.plans)
        measured, failed = fates["succeeded"], fates["failed"] + stood
        left = None if plan is None else max(0, plan - fates.total() - stood)
        return j.Points(plan=plan, measured=measured, failed=failed, left=left)

    @property
    def is_through(self) -> bool:
        """True if its loops are through, and not one iteration succeeded: only its holes are left."""
        points = self.points()
        return bool(self.failed) and points.left == 0 and points.measured == 0

    # --- devices

    def was_before(self, device: str, goal_id: str, other: str) -> bool:
        """True if `goal_id` was certainly requested of the device before `other`.

        One that this journal does not have may have come later, in a part of it that is lost.
        """
        order = self.order.get(device, deque())
        if goal_id not in order or other not in order:
            return False
        return order.index(goal_id) < order.index(other)

    def _has_lost(self, device: str, told: Mapping[str, Any]) -> bool:
        """True if a device has done a goal of this run that this journal does not have."""
        order, goal_id = self.order.get(device, deque()), str(told.get("goal_id"))
        ours = self.started is not None and goal_id.startswith(f"{self.started.run}/")
        return ours and goal_id not in order and len(order) < ORDER_KEPT

    def is_remembered(self, sent: j.GoalSent) -> bool:
        """True if the device has the ledger that it had when a goal was sent, or ought to know it."""
        return sent.n > self.ledger_n.get(sent.device, 0) and sent.device not in self.doubtful

    def held_since(self, sent: j.GoalSent) -> bool:
        """True if no other client has held a device since a goal was sent to it."""
        ours = self.epochs.get(sent.device, set())
        unbroken = sent.epoch in ours and all(e in ours for e in range(sent.epoch, max(ours) + 1))
        return unbroken and self.is_remembered(sent)

    def somebody_was_there(self, device: str, boot: str, epoch: int) -> bool:
        """True if a new lease does not directly follow this run's last one on a device."""
        ours = self.epochs.get(device)
        if not ours:
            return False
        same = ledger_of(boot) == ledger_of(self.lease_boots.get(device, boot))
        return not same or epoch not in (max(ours), max(ours) + 1)

    def is_stale(self, past: PastGoal) -> bool:
        """True when the device was touched since this goal ended, so its state may be lost."""
        return self.touched.get(past.sent.device, 0) > past.state_n

    def is_replaced(self, past: PastGoal) -> bool:
        """True if what it had set was about to be set otherwise by the next thing that is done again.

        Where its branch or iteration is over, nothing needs it any more: a furnace on its way down is
        not heated first.
        """
        row = self.in_a_row.get((past.sent.device, past.sent.sets))
        return row is not None and row.first_n <= past.sent.n < row.path_n


def read_history(records: Iterable[j.JournalRecord], *, comparing: bool = False) -> History:
    """What all records of a journal say.

    Iterations that a change of the protocol or a redo has reopened since are not finished.
    """
    if not isinstance(records, Records | Sequence):
        records = list(records)
    history = History(past=Past(comparing=comparing))
    is_superseded = superseded(records)
    for record in records:
        if isinstance(record, j.IterationEnded) and is_superseded(record) and not comparing:
            continue
        history.take(record)
    if history.started is None:
        raise JournalFault(
            "the journal has no start of a run: it was killed before it began, or its journal was "
            "emptied; there is nothing to resume, so start it anew"
        )
    return history


def superseded(records: Iterable[j.JournalRecord]) -> Callable[[j.IterationEnded], bool]:
    """Whether an iteration's end no longer counts: it was reopened since, or is measured again."""
    if isinstance(records, Records):
        records = records.of("changed", "redo")
    reopened: dict[str, int] = {}
    redone: dict[str, int] = {}
    for record in records:
        if isinstance(record, j.Changed | j.Redo):
            reopened |= dict.fromkeys(record.reopened, record.n)
        if isinstance(record, j.Redo):
            redone |= dict.fromkeys(record.iterations, record.n)

    def is_superseded(ended: j.IterationEnded) -> bool:
        path = f"{ended.loop}/{ended.key}"
        if ended.n < reopened.get(path, 0):
            return True
        return bool(redone) and any(ended.n < redone.get(p, 0) for p in upwards(path))

    return is_superseded
