"""Alternatives in order: the next one is tried when the one before has failed for good."""

from dataclasses import dataclass, replace

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ....schemas.journal import Turned
from ...run.frame import Scope
from ...run.run import Run
from .action_set import ActionSet
from .failure import Failure
from .node import Parent, failure_of, result_of
from .replay_failed import failed_anew, replay_failed

ASKED = ("repeat", "skip", "stop")


@dataclass(frozen=True, slots=True)
class Alternative:
    """One way to continue; `asks` is True for a question whose answers mean repeat, skip, stop."""

    node: Behaviour
    scope: Scope
    asks: bool = False


class Fallback(Parent):
    """The step's result is that of the alternative that succeeded.

    `error` in an alternative is the failure before it. A person's `repeat` starts again with the
    step itself, one level deeper in the path, so that no goal id occurs twice. In a set, what has
    succeeded is not repeated, and an alternative gives its result for what has not.
    """

    def __init__(
        self, name: str, run: Run, primary: Behaviour, inner: Scope,
        alternatives: list[Alternative], outer: Scope,
    ) -> None:  # fmt: skip
        super().__init__(name, run, [primary, *(a.node for a in alternatives)])
        self.alternatives = alternatives
        self.inner = inner
        self.outer = outer
        self.current = 0
        self.round = 1
        self.rounds_gone = 0
        self.gone = 0
        self.gone_with: Failure | None = None
        self.entered_at = ""

    @property
    def path(self) -> str:
        """The current path of the step."""
        return f"{self.outer.frame.path}/{self.name}"

    def initialise(self) -> None:
        turns = self.run.past.turned
        self.rounds_gone = 0
        if (
            self.path == self.entered_at
        ):  # again in the same place, after a pause: it needs its own ids
            self._next_round()
        else:
            repeated = turns.get(f"{self.path}/a")
            newest = repeated.turn if repeated is not None else 1
            self.rounds_gone = newest - 1 if isinstance(self.children[0], ActionSet) else 0
            self._enter_round(1 if self.rounds_gone else newest)
        self.entered_at = self.path
        self._remember_ways()

    def _remember_ways(self) -> None:
        past = self.run.past.turned.get(f"{self._base()}/f")
        if past is not None and past.error is not None:
            self.gone, self.gone_with = past.turn, Failure.from_error(past.error)

    def _earlier_rounds(self, primary: ActionSet) -> None:
        """What succeeded in a set before a person chose `repeat` and the engine died is done."""
        while self.round <= self.rounds_gone:
            replay_failed(primary)
            if primary.status == Status.RUNNING:
                return
            anew = failed_anew(primary)
            if anew is not None:
                self.status = self.fail(anew)
                return
            primary.keep_done()
            self._enter_round(self.round + 1)
            self._remember_ways()

    def advance(self) -> None:
        primary = self.children[0]
        if isinstance(primary, ActionSet) and self.round <= self.rounds_gone:
            self._earlier_rounds(primary)
            if self.round <= self.rounds_gone:
                return
        while self.status == Status.RUNNING:
            child = self.children[self.current]
            is_gone = self.current < self.gone
            if is_gone:
                replay_failed(child)
            else:
                child.tick_once()
            if child.status == Status.RUNNING:
                return
            if is_gone:
                self._gone(child)
            elif child.status == Status.SUCCESS:
                self._succeeded(child)
            else:
                self._failed(failure_of(child))

    def _gone(self, child: Behaviour) -> None:
        """A branch that had failed before the crash: on to the next, as then."""
        anew = failed_anew(child)
        if anew is not None:
            self.status = self.fail(anew)
            return
        last = self.current + 1 == self.gone
        failed = failure_of(child) if child.status == Status.FAILURE else None
        assert self.gone_with is not None
        self._enter(self.current + 1, self.gone_with if last or failed is None else failed)

    def _succeeded(self, child: Behaviour) -> None:
        self.result = result_of(child)
        if self.current and self.alternatives[self.current - 1].asks:
            self._answered(self.result["choice"])
            return
        primary = self.children[0]
        if self.current and isinstance(primary, ActionSet):
            self.result = primary.with_in_place(self.result)
        self.status = Status.SUCCESS

    def _answered(self, choice: str) -> None:
        assert self.failure is not None
        if choice == "repeat":
            if isinstance(self.children[0], ActionSet):
                self.children[0].keep_done()
            self._next_round()
        elif choice in ASKED:
            skip = choice == "skip"
            self.status = self.fail(replace(self.failure, skip=skip, stop=not skip))
        else:
            self.status = Status.SUCCESS

    def _failed(self, failure: Failure) -> None:
        last = self.current == len(self.children) - 1
        if last or failure.skip or failure.stop or failure.bygone or failure.anew:
            self.status = self.fail(failure)
            return
        self.run.record(
            Turned(path=f"{self._base()}/f", turn=self.current + 1, error=failure.as_error())
        )
        told = failure.told_in(self.outer.frame)
        self.run.log(f"{told} (fallback {self.current + 1})", self.path)
        self._enter(self.current + 1, failure)

    def _next_round(self) -> None:
        self.run.record(Turned(path=f"{self.path}/a", turn=self.round + 1))
        self._enter_round(self.round + 1)

    def _base(self) -> str:
        return self.path if self.round == 1 else f"{self.path}/a{self.round}"

    def _enter_round(self, number: int) -> None:
        self.round, self.current, self.failure = number, 0, None
        self.gone, self.gone_with = 0, None
        frame = self.outer.frame
        self.inner.frame = frame if number == 1 else frame.within(self._base())

    def _enter(self, index: int, failure: Failure) -> None:
        self.current, self.failure = index, failure
        names = {"error": failure.as_error()}
        scope = self.alternatives[index - 1].scope
        scope.frame = self.outer.frame.within(f"{self._base()}/f{index}", names)
