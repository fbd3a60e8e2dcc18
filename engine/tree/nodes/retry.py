"""Try again what failed, up to a total number of attempts, without blocking in between."""

import random
from dataclasses import dataclass, replace

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ....schemas.journal import Turned
from ...run.frame import Frame, Scope
from ...run.run import Run
from .failure import Failure
from .node import Parent, failure_of, result_of
from .replay_failed import failed_anew, replay_failed


@dataclass(frozen=True, slots=True)
class RetryRules:
    """`attempts` counts the first one too."""

    attempts: int
    wait_s: float = 0.0
    factor: float = 1.0
    max_wait_s: float | None = None
    jitter: float = 0.0
    on: frozenset[str] | None = None

    def allows(self, failure: Failure) -> bool:
        """Whether this failure may be tried again: a `once` action only if it did not happen."""
        if failure.skip or failure.stop:
            return False
        named = self.on is not None and failure.name in self.on
        if failure.once and failure.happened == "unknown":
            return False
        if failure.once and failure.happened == "yes":
            return named
        return self.on is None or named

    def pause_s(self, attempt: int) -> float:
        """How long to wait after the n-th attempt."""
        wait = self.wait_s * self.factor ** (attempt - 1)
        wait = wait if self.max_wait_s is None else min(wait, self.max_wait_s)
        return wait * (1 + self.jitter * random.uniform(-1, 1))


class Retry(Parent):
    """Enters its child again after a failure.

    A single action numbers its own attempts; a group gets its own frame from the second turn
    on (`inner` is its scope), so that no goal id occurs twice.
    """

    def __init__(
        self, name: str, run: Run, rules: RetryRules, child: Behaviour,
        outer: Scope, inner: Scope | None,
    ) -> None:  # fmt: skip
        super().__init__(name, run, [child])
        self.child = child
        self.rules = rules
        self.outer = outer
        self.inner = inner
        self.turn = 1
        self.level = 1
        self.gone = 0
        self.entered_at = ""
        self.until: float | None = None

    @property
    def path(self) -> str:
        """The current path of the retried step."""
        return f"{self.outer.frame.path}/{self.name}"

    def initialise(self) -> None:
        self.turn, self.until, self.gone = 1, None, 0
        if self.inner is None:
            return
        again = self.path == self.entered_at  # after a pause: it needs its own ids
        self.level = self.level + 1 if again else 1
        self.entered_at = self.path
        past = self.run.past.turned.get(f"{self.path}/r")
        self.gone = past.turn - 1 if past is not None and not again else 0
        self.inner.frame = self._frame()

    def advance(self) -> None:
        while self.level <= self.gone:
            replay_failed(self.child)
            if self.child.status == Status.RUNNING:
                return
            anew = failed_anew(self.child)
            if anew is not None:
                self.status = self.fail(anew)
                return
            self._next_turn()
            if self.level > self.gone and self.run.past.begun_anew:
                self.turn = 1
        if self.until is not None:
            if self.run.clock.now() < self.until:
                self.run.requests.wake_at(self.until)
                return
            self.until = None
        self.child.tick_once()
        if self.child.status == Status.SUCCESS:
            self.result = result_of(self.child)
            self.status = Status.SUCCESS
        elif self.child.status == Status.FAILURE:
            self._failed(failure_of(self.child))

    def _failed(self, failure: Failure) -> None:
        came_so_far = failure.bygone or failure.anew
        spent = self.turn >= self.rules.attempts
        if came_so_far or spent or not self.rules.allows(failure):
            self.status = self.fail(failure if came_so_far else replace(failure, tries=self.turn))
            return
        wait_s = self.rules.pause_s(self.turn)
        self.run.log(
            f"{failure.told_in(self.outer.frame)} (attempt {self.turn} of {self.rules.attempts}"
            + (f", again in {wait_s:g} s)" if wait_s else ", again)"),
            self.path,
        )
        self.until = None if self.replaying else self.run.clock.now() + wait_s
        self._next_turn()
        if self.inner is not None:
            self.run.record(
                Turned(path=f"{self.path}/r", turn=self.level, error=failure.as_error())
            )
        self.run.requests.again()

    def _next_turn(self) -> None:
        self.turn = min(self.turn + 1, self.rules.attempts)
        self.level += 1
        if self.inner is not None:
            self.inner.frame = self._frame()

    def _frame(self) -> Frame:
        frame = self.outer.frame
        return frame if self.level == 1 else frame.within(f"{frame.path}/{self.name}/r{self.level}")
