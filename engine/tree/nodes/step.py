"""What any step may have around its kind: `when`, a total `timeout`, `on_error`, a result by id."""

from dataclasses import dataclass
from datetime import datetime
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ....schemas.journal import Turned
from ....schemas.quantity import quantity, seconds
from ...language.expression import ExpressionError
from ...language.value import Value
from ...run.frame import Scope
from ...run.run import Run
from .failure import Failure
from .finally_of_use import FinallyOfUse
from .node import Parent, failure_of, result_of
from .replay_failed import failed_anew, replay_failed


@dataclass(frozen=True, slots=True)
class StepRules:
    """The rules of one step that apply to every kind."""

    segment: str
    id: str | None = None
    when: Value | None = None
    timeout_s: Value | None = None
    on_error: str = "stop"
    in_loop: bool = False
    in_finally: bool = False
    silent: bool = False
    timed: bool = False
    """Whether an expression asks when it began or how long it took."""


class StepNode(Parent):
    """Guards one step, keeps its result, and decides whether its failure goes up.

    That its time was over is in the journal: a run that goes on behind it does not begin it again.
    """

    def __init__(self, run: Run, scope: Scope, rules: StepRules, child: Behaviour) -> None:
        super().__init__(rules.segment, run, [child])
        self.child = child
        self.scope = scope
        self.rules = rules
        self.until: float | None = None
        self.held = False
        self.too_long = False
        self.skipped = False
        self.finally_due: FinallyOfUse | None = None

    @property
    def path(self) -> str:
        """The current path of this step."""
        return f"{self.scope.frame.path}/{self.rules.segment}"

    def initialise(self) -> None:
        rules, names = self.rules, self.scope.frame.names
        if self.run.asks_clocks:
            names = self.run.names(names, f"{self.path}/guard")
        self.until, self.held, self.skipped, self.finally_due = None, False, False, None
        done = self.run.past
        past = done.turned.get(f"{self.path}/t")
        self.too_long = past is not None and (self.replaying or not done.is_over(past))
        try:
            if rules.when is not None and not rules.when.evaluate(names):
                self.skipped = True
                self._store(None)
                self.run.tell("step", self.path, "skipped")
                self.status = Status.SUCCESS
                return
            if rules.timeout_s is not None:
                self.until = self.run.clock.now() + seconds(rules.timeout_s.evaluate(names))
        except (ExpressionError, ValueError) as fault:
            self.status = self.fail(Failure("Expression", str(fault), step=self.path))
            return
        if rules.timed:
            self.run.computed(f"{self.path}/started", self.run.clock.time_of_day)
        self._tell("running")

    def advance(self) -> None:
        if self.held:
            self._go_on_after_pause()
            return
        if self.finally_due is not None:
            self._close(self.finally_due)
            return
        if self.too_long:
            self._before_it_was_stopped()
            return
        self.child.tick_once()
        if self.child.status == Status.SUCCESS:
            self.result = result_of(self.child)
            self._store(self.result)
            if self.rules.timed:
                self._store_times()
            self._tell("succeeded")
            self.status = Status.SUCCESS
        elif self.child.status == Status.FAILURE:
            self._failed(failure_of(self.child).at(self.path))
        elif self.until is not None:
            self._check_time(self.until)
            if self.finally_due is not None:
                self._close(self.finally_due)

    def terminate(self, new_status: Status) -> None:
        if self.finally_due is not None:
            self.finally_due.stop()

    def _close(self, finally_due: FinallyOfUse) -> None:
        finally_due.tick_once()
        if not finally_due.due:
            self.run.record(Turned(path=f"{self.path}/t", turn=1))
            self._failed(self._timeout())

    def _before_it_was_stopped(self) -> None:
        """What it did and set in an earlier session, before it timed out then."""
        replay_failed(self.child)
        if self.child.status != Status.RUNNING:
            self._failed(failed_anew(self.child) or self._timeout())

    def _timeout(self) -> Failure:
        return Failure("Timeout", "the step took longer than its timeout", step=self.path)

    def _check_time(self, until: float) -> None:
        if self.run.clock.now() < until:
            self.run.requests.wake_at(until)
            return
        self.child.stop(Status.INVALID)
        self.finally_due = FinallyOfUse(self, [self.path])

    def _failed(self, failure: Failure) -> None:
        if failure.bygone or failure.anew:
            self.status = self.fail(failure)
            return
        skips_here = failure.skip and not self.rules.in_loop
        goes_on = self.rules.on_error == "continue" and not failure.skip and not failure.stop
        self._store(None)
        self.run.tell("step", self.path, "failed", failure.sentence())
        if skips_here or goes_on:
            told = failure.told_in(self.scope.frame)
            self.run.log(f"{told} (the run continues)", self.path)
            if self.rules.in_finally:
                self.run.left_undone[self.path] = failure.words()
            self.status = Status.SUCCESS
        elif self.rules.on_error == "pause" and not failure.skip and not failure.stop:
            self.run.requests.pause = (
                f"{failure.told_in(self.scope.frame)}; `labrun continue` tries the step again"
            )
            self.held = True
            self.run.requests.again()
        else:
            self.status = self.fail(failure)

    def _go_on_after_pause(self) -> None:
        # The runner does not tick a paused tree past its running set, so being ticked without
        # a pause still wanted means that a person chose `continue`. The step is tried again from
        # the journal, so that what had succeeded in it is done, and no goal id occurs twice.
        if not self.run.requests.pause:
            self.run.requests.take_up = True
            self.run.requests.again()

    def _tell(self, state: str) -> None:
        if not self.rules.silent and self.run.is_heard("step"):
            self.run.tell("step", self.path, state)

    def _store_times(self) -> None:
        began = self.run.computed(f"{self.path}/started", self.run.clock.time_of_day)
        took = self.run.computed(f"{self.path}/took", lambda: self._since(began))
        self.scope.frame.store_times(str(self.rules.id), {"started": began, "took": took})

    def _since(self, began: datetime) -> Any:
        """Never less than nothing, though the computer's clock may have been set back."""
        past_s = (self.run.clock.time_of_day() - began).total_seconds()
        return quantity(max(0.0, past_s), "s")

    def _store(self, result: object) -> None:
        if self.rules.id is not None:
            self.scope.frame.store(self.rules.id, result)
            if self.rules.timed:
                self.scope.frame.store_times(self.rules.id, {})
