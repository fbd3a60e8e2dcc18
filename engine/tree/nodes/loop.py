"""A loop: one subtree, entered again for each turn; of a finished one, key and fate stay in memory."""

from collections import Counter, deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ....schemas.journal import IterationEnded, LoopEnded, Planned, StepFate
from ...dispatch.dispatcher import Dispatcher
from ...journal.encode import decode, encode
from ...language.expression import ExpressionError
from ...language.value import Value
from ...run.frame import Frame, Scope
from ...run.rows import Rows
from ...run.run import Run
from .action_set import gravest
from .background import all_ended, stop_pending, tick_pending
from .failure import Failure
from .iterations import Iterations, NotOver, whole
from .node import Parent, failure_of
from .set_again import SetAgain, settings_of

ITERATIONS_PER_TICK = 200
"""A limit, so that a long loop of instant steps does not hold up results, signals and the screen."""


@dataclass(frozen=True, slots=True)
class LoopPlan:
    """What one loop states besides its iterations."""

    segment: str
    keeps_going: bool
    max_failed: Value | None
    in_a_row: Value | None
    background: int
    nested: bool
    at_once: Value | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Slot:
    """One body, in which one iteration after the other runs."""

    scope: Scope
    body: Behaviour


@dataclass(slots=True, eq=False)
class Iteration:
    """One turn under way, or over except for background actions, or for those before it.

    `fate`: it is in the journal already, with this fate.
    """

    index: int
    key: str
    frame: Frame
    slot: Slot | None = None
    failure: Failure | None = None
    fate: StepFate | None = None

    @property
    def is_over(self) -> bool:
        """Whether its steps have ended, and what they had begun in the background."""
        return self.fate is not None or (self.slot is None and all_ended(self.frame))


class Loop(Parent):
    """Rebinds its names and enters its body again; finished iterations of earlier sessions are left out.

    An iteration is finished when its steps and its background actions have ended; rows, counts and
    failures come in the order of the turns. With several at once each has a body of its own, and one that has
    succeeded is in the journal before those before it.
    """

    def __init__(
        self,
        run: Run,
        outer: Scope,
        plan: LoopPlan,
        turns: Iterations,
        build: Callable[[], tuple[Scope, Behaviour]],
        rows: Rows | None,
        dispatcher: Dispatcher,
    ) -> None:
        first = Slot(*build())
        super().__init__(plan.segment, run, [first.body])
        self.dispatcher = dispatcher
        self.build = build
        self.slots = [first]
        self.free = [first]
        self.outer = outer
        self.plan = plan
        self.turns = turns
        self.rows = rows
        self.path = ""
        self.position = 0
        self.at_once = 1
        self.counts: Counter[StepFate] = Counter()
        self.max_failed: int | None = None
        self.in_a_row: int | None = None
        self.failed_last = 0
        """How many iterations before this one have failed, one after the other."""
        self.open: deque[Iteration] = deque()
        """In the order of the turns, from the first that is not finished."""
        self.no_more = False
        """One has failed for which the loop will end: no other is begun."""
        self.done_before: dict[str, StepFate] = {}
        self.last_done = -1
        self.settings: deque[SetAgain] = deque()

    # --- beginning

    def initialise(self) -> None:
        self.path = f"{self.outer.frame.path}/{self.plan.segment}"
        self.position, self.counts, self.failed_last = 0, Counter(), 0
        self.no_more, self.free = False, list(self.slots)
        self.open.clear()
        try:
            names = self.run.names(self.outer.frame.names, f"{self.path}/begin")
            self.turns.begin(names)
            self.max_failed = _limit(self.plan.max_failed, names)
            self.in_a_row = _limit(self.plan.in_a_row, names)
            if self.plan.at_once is not None:
                self.at_once = max(1, whole("at_once", self.plan.at_once.evaluate(names)))
        except (ExpressionError, ValueError, TypeError) as fault:
            self.status = self.fail(Failure("Expression", str(fault), step=self.path))
            return
        done = self.run.past
        self.done_before = done.iterations.pop(self.path, {})
        if self.turns.total is None:
            again = (p.removeprefix(f"{self.path}/") for p in done.passes)
            known = (int(key) for key in (*self.done_before, *again) if key.isdecimal())
            self.last_done = max(known, default=-1)
        for name, value in done.sets.pop(self.path, {}).items():
            self.outer.frame.assign(name, decode(value))
        self.settings = settings_of(
            self.run, self.outer, self.dispatcher, self.plan.segment, self.path
        )
        for setting in self.settings:
            setting.parent = self
        if not (self.plan.nested or self.replaying or done.comparing):
            self._record_plan()
        self._tell("begun")

    def _record_plan(self) -> None:
        known = self.run.history.plans
        if self.path not in known or known[self.path] != self.turns.total:
            self.run.record(Planned(loop=self.path, total=self.turns.total))

    # --- one tick

    def advance(self) -> None:
        self._set_again()
        if self.settings or self.status != Status.RUNNING:
            return
        going = [one for one in self.open if one.slot is not None]
        for _ in range(ITERATIONS_PER_TICK):
            for iteration in self.open:
                tick_pending(iteration.frame)
            for iteration in going:
                slot = iteration.slot
                assert slot is not None
                slot.body.tick_once()
                if slot.body.status != Status.RUNNING:
                    self._body_ended(iteration, slot)
            self._finish_in_order()
            if self.status != Status.RUNNING:
                return
            entered = self._enter_next()
            if entered is None:
                return
            going = [entered]
        self.run.requests.again()

    def _set_again(self) -> None:
        while self.settings:
            setting = self.settings[0]
            setting.tick_once()
            if setting.status == Status.RUNNING:
                return
            self.settings.popleft()
            if setting.status == Status.FAILURE:
                self.status = self.fail(failure_of(setting))
                return

    def _enter_next(self) -> Iteration | None:
        """Start the next turn; None when there is nothing to do in this tick."""
        while self.failure is None and not self.no_more and self._has_room():
            if not self._has_more():
                break
            iteration = self._iteration(self.position)
            if self.run.past.knows_nothing_of(iteration.frame.path):
                if self.turns.total is None:
                    break  # a comparison knows nothing of this turn, nor of the next one
                self.position += 1
                continue
            self.position += 1
            iteration.fate = self.done_before.pop(iteration.key, None)
            if iteration.fate is not None and (self.at_once == 1 or not self.open):
                self._count(iteration.fate)
                self._release_rows()
                continue
            self.open.append(iteration)
            if iteration.fate is None:
                iteration.slot = self._slot()
                iteration.slot.scope.frame = iteration.frame
                self._tell("running", index=iteration.index, key=iteration.key)
                return iteration
        if not self.open:
            self._end()
        return None

    def _has_room(self) -> bool:
        """Whether another turn may begin, as to those that run or have things in the background."""
        if self.at_once == 1:
            running = any(one.slot is not None for one in self.open)
            return not running and len(self.open) <= self.plan.background
        running = sum(one.slot is not None for one in self.open)
        behind = sum(one.slot is None and not one.is_over for one in self.open)
        return running < self.at_once and behind <= self.plan.background * self.at_once

    def _slot(self) -> Slot:
        if self.free:
            return self.free.pop()
        slot = Slot(*self.build())
        self.slots.append(slot)
        self.children.append(slot.body)
        slot.body.parent = self
        return slot

    def _has_more(self) -> bool:
        if self.turns.total is None and self._was_entered(self.position):
            return True  # its condition held then, before the changes by the turns since
        limit = self.run.turns_at_most
        if limit is not None and self.turns.endless and self.position >= limit:
            message = (
                f"a `while` without `max` has taken {limit:,} turns: in a rehearsal, what it waits for "
                "may never come. Give it `max`, or more --turns"
            )
            self.failure = Failure("Endless", message, step=self.path, stop=True)
            return False
        try:
            place = f"{self.path}/{self.position}/while"
            return self.turns.more(self.position, self.run.names(self.outer.frame.names, place))
        except NotOver as fault:
            self.failure = Failure("MaxReached", str(fault), step=self.path)
        except (ExpressionError, ValueError) as fault:
            self.failure = Failure("Expression", str(fault), step=self.path)
        return False

    def _was_entered(self, index: int) -> bool:
        """Whether an earlier engine session has finished this turn, or one after it."""
        if self.run.past.comparing:
            return not self.run.past.knows_nothing_of(f"{self.path}/{index}")
        return index <= self.last_done

    def _iteration(self, index: int) -> Iteration:
        own = self.turns.own(index)
        outer = self.outer.frame
        key = self.turns.key(index, outer.names.new_child(own))
        path = self.run.past.pass_path(f"{self.path}/{key}")
        made = Iteration(index, key, outer.iteration(path, key, own))
        made.frame.around = (*outer.around, (self.turns.words, index))
        if self.at_once > 1:
            made.frame.strand = outer.strand or path
        return made

    def _body_ended(self, iteration: Iteration, slot: Slot) -> None:
        iteration.slot = None
        self.free.append(slot)
        if slot.body.status == Status.FAILURE:
            iteration.failure = failure_of(slot.body)
            if self._will_end(iteration.failure):
                self.no_more = True

    def _will_end(self, failure: Failure) -> bool:
        """Whether the loop ends for this failure, whatever becomes of the turns before."""
        if self.at_once > 1 and self.plan.keeps_going:
            return failure.stop or failure.bygone or failure.anew
        return not self._may_go_on(failure)

    def _finish_in_order(self) -> None:
        while self.open and self.open[0].is_over:
            iteration = self.open.popleft()
            if iteration.fate is None:
                self._finish(iteration)
            else:
                self._count(iteration.fate)
            self._release_rows()
        if self.at_once > 1 and not self.run.past.comparing:
            self._record_ahead()
        if not self.open and self.no_more and self.failure is None:
            self.no_more = False  # none of them ends the loop after all
        if self.failure is not None and not self.open:
            self._end()

    def _record_ahead(self) -> None:
        """What has succeeded is in the journal before those before it: a resumed run does not repeat it."""
        for iteration in self.open:
            if iteration.fate is None and iteration.is_over and self._why(iteration) is None:
                self._record(iteration, None, ahead=True)
                iteration.fate = "succeeded"

    def _why(self, iteration: Iteration) -> Failure | None:
        """Why an iteration that is over has failed, if it has."""
        pending = iteration.frame.pending
        if iteration.failure is not None or not pending:
            return iteration.failure
        failed = [failure_of(a) for a in pending if a.status == Status.FAILURE]
        return gravest(failed) if failed else None

    def _finish(self, iteration: Iteration) -> None:
        failure = self._why(iteration)
        if failure is not None and not self._may_go_on(failure):
            # This iteration ends the run; it stays unfinished, so that resume continues it.
            placed = replace(
                self._placed(failure, iteration), limit=self._limit_passed(failure)
            )  # fmt: skip
            self.failure = placed if self.failure is None else gravest([self.failure, placed])
            return
        self._count("succeeded" if failure is None else "failed")
        self._record(iteration, failure, ahead=self.failure is not None)

    def _record(self, iteration: Iteration, failure: Failure | None, *, ahead: bool) -> None:
        fate: StepFate = "succeeded" if failure is None else "failed"
        row = self._write_row(iteration, fate, ahead=ahead)
        if failure is not None:
            told = self._placed(failure, iteration).told_in(self.outer.frame)
            self.run.log(f"{told} (left out: a hole)", iteration.frame.path)
        self.run.record(
            IterationEnded(
                loop=self.path, index=iteration.index, key=iteration.key,
                within=self.outer.frame.keys, fate=fate,
                row=encode(row) if row is not None else None,
                file=self.rows.path.name if self.rows is not None else "",
                sets=encode(iteration.frame.outer_sets),
                message=failure.sentence() if failure else "", ahead=ahead,
            )
        )  # fmt: skip
        self._tell(fate, index=iteration.index, key=iteration.key)

    def _release_rows(self) -> None:
        if self.rows is not None and self.at_once > 1:
            before = self.open[0].index if self.open else self.position
            if told := self.rows.release(self.path, before):
                self.run.log(told)

    def _placed(self, failure: Failure, iteration: Iteration) -> Failure:
        place = self.turns.words(iteration.index)
        return replace(failure, where=(place, *failure.where))

    def _limit_passed(self, failure: Failure) -> str:
        ends_all = failure.stop or failure.bygone or failure.anew
        if ends_all or failure.limit or not self.plan.keeps_going:
            return failure.limit
        if self.max_failed is not None and self.counts["failed"] >= self.max_failed:
            return f"no more than {self.max_failed} may fail"
        return f"no more than {self.in_a_row} in a row may fail"

    def _write_row(
        self, iteration: Iteration, fate: StepFate, *, ahead: bool
    ) -> dict[str, Any] | None:
        if self.rows is None:
            return None
        place = f"{iteration.frame.path}/collect"
        row = self.rows.evaluate(self.run.names(iteration.frame.names, place))
        if ahead:
            self.rows.hold(self.path, iteration.index, iteration.frame.keys, row, fate)
        elif told := self.rows.write(iteration.frame.keys, row, fate):
            self.run.log(told)
        return row

    def _count(self, fate: StepFate) -> None:
        self.counts[fate] += 1
        self.failed_last = self.failed_last + 1 if fate == "failed" else 0

    def _may_go_on(self, failure: Failure) -> bool:
        if failure.stop or failure.bygone or failure.anew:
            return False
        if failure.skip or not self.plan.keeps_going:
            return failure.skip
        too_many = self.max_failed is not None and self.counts["failed"] >= self.max_failed
        return not too_many and (self.in_a_row is None or self.failed_last < self.in_a_row)

    # --- ending

    def _end(self) -> None:
        if self.rows is not None and (told := self.rows.release(self.path)):
            self.run.log(told)
        if self.failure is None and self.counts["failed"] and not self.counts["succeeded"]:
            self.failure = self._nothing_succeeded()
        fates: tuple[StepFate, ...] = ("succeeded", "failed", "skipped")
        self.result = {"total": self.counts.total(), **{fate: self.counts[fate] for fate in fates}}
        fate: StepFate = "succeeded" if self.failure is None else "failed"
        if not self.plan.nested:
            self.run.record(LoopEnded(loop=self.path, fate=fate, **self.result))
        self._tell("ended")
        self.status = Status.SUCCESS if self.failure is None else Status.FAILURE

    def _nothing_succeeded(self) -> Failure:
        failed = self.counts["failed"]
        which = f"none of its {failed} iterations" if failed > 1 else "its only iteration"
        return Failure("NothingSucceeded", f"{which} succeeded", step=self.path)

    def _tell(self, state: str, **data: Any) -> None:
        if self.run.is_heard("iteration"):
            self.run.tell(
                "iteration", self.path, state, total=self.turns.total, done=self.counts.total(),
                failed=self.counts["failed"], **data,
            )  # fmt: skip

    def stop(self, new_status: Status) -> None:
        if new_status == Status.INVALID and self.status == Status.RUNNING:
            for iteration in self.open:
                stop_pending(iteration.frame)
            for setting in self.settings:
                setting.stop(Status.INVALID)
        super().stop(new_status)


def _limit(limit: Value | None, names: Mapping[str, Any]) -> int | None:
    return None if limit is None else int(limit.evaluate(names))
