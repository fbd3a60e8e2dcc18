"""A loop: one subtree, entered again for each turn; of a finished one, key and fate stay in memory."""

from collections import Counter, deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
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
from .iterations import Iterations, NotOver
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


@dataclass(slots=True)
class Iteration:
    """One turn under way, or done except for background actions."""

    index: int
    key: str
    frame: Frame
    failure: Failure | None = None
    over: bool = field(default=False)


class Loop(Parent):
    """Rebinds its names and enters its body again; finished iterations of earlier sessions are left out.

    An iteration is finished when its steps and its background actions have ended; rows and
    records come in the order of the turns.
    """

    def __init__(
        self,
        run: Run,
        outer: Scope,
        inner: Scope,
        plan: LoopPlan,
        turns: Iterations,
        body: Behaviour,
        rows: Rows | None,
        dispatcher: Dispatcher,
    ) -> None:
        super().__init__(plan.segment, run, [body])
        self.dispatcher = dispatcher
        self.body = body
        self.outer = outer
        self.inner = inner
        self.plan = plan
        self.turns = turns
        self.rows = rows
        self.path = ""
        self.position = 0
        self.counts: Counter[StepFate] = Counter()
        self.max_failed: int | None = None
        self.in_a_row: int | None = None
        self.failed_last = 0
        """How many iterations before this one have failed, one after the other."""
        self.open: deque[Iteration] = deque()
        self.current: Iteration | None = None
        self.done_before: dict[str, StepFate] = {}
        self.last_done = -1
        self.settings: deque[SetAgain] = deque()

    # --- beginning

    def initialise(self) -> None:
        self.path = f"{self.outer.frame.path}/{self.plan.segment}"
        self.position, self.current, self.counts, self.failed_last = 0, None, Counter(), 0
        self.open.clear()
        try:
            names = self.run.names(self.outer.frame.names, f"{self.path}/begin")
            self.turns.begin(names)
            self.max_failed = _limit(self.plan.max_failed, names)
            self.in_a_row = _limit(self.plan.in_a_row, names)
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
        if not (self.plan.nested or self.run.replaying or done.comparing):
            self._record_plan()
        self._tell("begun")

    def _record_plan(self) -> None:
        known = self.run.history.plans
        if self.path not in known or known[self.path] != self.turns.total:
            self.run.record(Planned(loop=self.path, total=self.turns.total))

    # --- one tick

    def advance(self) -> Iterator[Behaviour]:
        yield from self._set_again()
        if self.settings or self.status != Status.RUNNING:
            return
        for _ in range(ITERATIONS_PER_TICK):
            for iteration in self.open:
                yield from tick_pending(iteration.frame)
            self._finish_in_order()
            if self.status != Status.RUNNING:
                return
            if self.current is None and not self._enter_next():
                return
            yield from self.body.tick()
            if self.body.status == Status.RUNNING:
                return
            self._body_ended()
        self.run.requests.again()

    def _set_again(self) -> Iterator[Behaviour]:
        while self.settings:
            setting = self.settings[0]
            yield from setting.tick()
            if setting.status == Status.RUNNING:
                return
            self.settings.popleft()
            if setting.status == Status.FAILURE:
                self.status = self.fail(failure_of(setting))
                return

    def _enter_next(self) -> bool:
        """Start the next turn; False when there is nothing to do in this tick."""
        while self.failure is None and len(self.open) <= self.plan.background:
            if not self._has_more():
                break
            iteration = self._iteration(self.position)
            if self.run.past.knows_nothing_of(iteration.frame.path):
                if self.turns.total is None:
                    break  # a comparison knows nothing of this turn, nor of the next one
                self.position += 1
                continue
            self.position += 1
            fate = self.done_before.pop(iteration.key, None)
            if fate is not None:
                self._count(fate)
                continue
            self.current = iteration
            self.inner.frame = iteration.frame
            self._tell("running", index=iteration.index, key=iteration.key)
            return True
        if not self.open:
            self._end()
        return False

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
        path = self.run.past.frame_path(f"{self.path}/{key}")
        return Iteration(index, key, outer.iteration(path, key, own))

    def _body_ended(self) -> None:
        assert self.current is not None
        if self.body.status == Status.FAILURE:
            self.current.failure = failure_of(self.body)
            if not self._may_go_on(self.current.failure):
                self.failure = self.current.failure
        self.open.append(self.current)
        self.current = None

    def _finish_in_order(self) -> None:
        while self.open and all_ended(self.open[0].frame):
            iteration = self.open.popleft()
            if iteration.failure is None:
                pending = iteration.frame.pending
                failed = [failure_of(a) for a in pending if a.status == Status.FAILURE]
                iteration.failure = gravest(failed) if failed else None
            self._finish(iteration)
        if self.failure is not None and not self.open and self.current is None:
            self._end()

    def _finish(self, iteration: Iteration) -> None:
        failure = iteration.failure
        fate: StepFate = "succeeded" if failure is None else "failed"
        if failure is not None and not self._may_go_on(failure):
            # This iteration ends the run; it stays unfinished, so that resume continues it.
            self.failure = replace(
                self._placed(failure, iteration), limit=self._limit_passed(failure)
            )
            return
        self._count(fate)
        row = self._write_row(iteration, fate)
        if failure is not None:
            words = self._placed(failure, iteration).words()
            self.run.log(f"{words} (left out: a hole)", iteration.frame.path)
        self.run.record(
            IterationEnded(
                loop=self.path, index=iteration.index, key=iteration.key,
                within=self.outer.frame.keys, fate=fate,
                row=encode(row) if row is not None else None,
                file=self.rows.path.name if self.rows is not None else "",
                sets=encode(iteration.frame.outer_sets),
                message=failure.sentence() if failure else "",
            )
        )  # fmt: skip
        self._tell(fate, index=iteration.index, key=iteration.key)

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

    def _write_row(self, iteration: Iteration, fate: StepFate) -> dict[str, Any] | None:
        if self.rows is None:
            return None
        place = f"{iteration.frame.path}/collect"
        row = self.rows.evaluate(self.run.names(iteration.frame.names, place))
        if told := self.rows.write(iteration.frame.keys, row, fate):
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
        if self.run.listeners:
            self.run.tell(
                "iteration", self.path, state, total=self.turns.total, done=self.counts.total(),
                failed=self.counts["failed"], **data,
            )  # fmt: skip

    def stop(self, new_status: Status) -> None:
        if new_status == Status.INVALID and self.status == Status.RUNNING:
            for iteration in (*self.open, *([self.current] if self.current else [])):
                stop_pending(iteration.frame)
            for setting in self.settings:
                setting.stop(Status.INVALID)
        super().stop(new_status)


def _limit(limit: Value | None, names: Mapping[str, Any]) -> int | None:
    return None if limit is None else int(limit.evaluate(names))
