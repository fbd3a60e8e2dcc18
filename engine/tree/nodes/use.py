"""`use`: the steps of another protocol, with its own parameters, names and `finally`."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from ....schemas.protocol import Param, Step
from ...language.expression import ExpressionError
from ...language.value import Value
from ...params.params import ParamFault, given_value, take
from ...run.finals import Final
from ...run.frame import Scope
from ...run.open_uses import OpenUse
from ...run.run import Run
from .failure import Failure
from .finally_of_use import begin_finally, finals_before
from .node import Parent, failure_of


@dataclass(frozen=True, slots=True)
class UsePlan:
    """What one `use` states, and what the other protocol declares."""

    segment: str
    arguments: Mapping[str, Value]
    params: Mapping[str, Param]
    outputs: Mapping[str, Value]
    tables: Any
    """The function `csv` of the other protocol, whose files are beside it."""
    last: Callable[[Scope], Behaviour] | None
    """Builds the tree of its `finally`."""
    last_steps: Sequence[Step]
    on_resume: Callable[[Any, Scope], Behaviour] | None
    """Builds the tree of its `on_resume`, with the compiler of the protocol that is run."""


class Use(Parent):
    """Ticks the other protocol's steps, then its `finally`, however they ended.

    Its result is the other protocol's outputs. If it is stopped from outside, its `finally` is left
    to the step that stopped it (see finally_of_use.py); after an abort, to the end of the run.
    """

    def __init__(
        self, run: Run, outer: Scope, inner: Scope, plan: UsePlan, body: Behaviour
    ) -> None:
        self.last_scope = Scope()
        self.last = plan.last(self.last_scope) if plan.last is not None else None
        super().__init__(plan.segment, run, [body] if self.last is None else [body, self.last])
        self.outer, self.inner, self.plan, self.body = outer, inner, plan, body
        self.over = False
        self.entered = ""

    @property
    def path(self) -> str:
        """The current path of this step."""
        return f"{self.outer.frame.path}/{self.plan.segment}"

    def initialise(self) -> None:
        self.over = False
        try:
            params = dict(self._params())
        except (ExpressionError, ParamFault) as fault:
            self.status = self.fail(Failure("Expression", str(fault), step=self.path))
            return
        names = {
            "params": params, "run": self.outer.frame.names["run"], "csv": self.plan.tables
        }  # fmt: skip
        self.inner.frame = self.outer.frame.another(self.path, names)
        if self.plan.last is not None:
            before = finals_before(self.run, self.path, replaying=self.replaying)
            final = Final(self.plan.last, self.plan.last_steps, names, self.inner.frame, before)
            self.run.finals.enter(self.path, final)
        if self.plan.on_resume is not None:
            self.entered = self.path
            self.run.open_uses[self.path] = OpenUse(self.path, names, self.plan.on_resume)

    def terminate(self, new_status: Status) -> None:
        self.run.open_uses.pop(self.entered, None)

    def _params(self) -> Iterator[tuple[str, Any]]:
        names = self.run.names(self.outer.frame.names, f"{self.path}/with")
        for name, param in self.plan.params.items():
            value = self.plan.arguments.get(name)
            given = param.default if value is None else value.evaluate(names)
            try:
                yield name, take(name, param, given_value(given), written=True)
            except ParamFault as fault:
                raise ParamFault(fault.code, f"{name}: {fault}") from fault

    def advance(self) -> None:
        if not self.over:
            self.body.tick_once()
            if self.body.status == Status.RUNNING:
                return
            self._body_over()
        if self.last is not None and self.status == Status.RUNNING:
            self.last.tick_once()
            if self.last.status == Status.RUNNING:
                return
            self._last_over(self.last)
        if self.status == Status.RUNNING:
            self.status = Status.SUCCESS if self.failure is None else Status.FAILURE

    def _body_over(self) -> None:
        self.over = True
        self.run.open_uses.pop(self.entered, None)
        if self.body.status == Status.FAILURE:
            self.failure = failure_of(self.body)
            if self.failure.anew:
                self.status = Status.FAILURE
                return
        else:
            self.result = {name: self._output(value) for name, value in self.plan.outputs.items()}
        if self.last is not None:
            self.last_scope.frame = begin_finally(
                self.run, self.path, failure=self.failure, stopped=False, replaying=self.replaying
            )

    def _output(self, value: Value) -> Any:
        try:
            place = f"{self.path}/outputs"
            return value.evaluate(self.run.names(self.inner.frame.names, place))
        except ExpressionError as fault:
            self.run.log(f"an output is null: {fault}", self.path)
            return None

    def _last_over(self, last: Behaviour) -> None:
        failure = failure_of(last) if last.status == Status.FAILURE else None
        self.run.finals.end(self.path, unfinished=failure is not None and failure.bygone)
        if failure is None:
            return
        if self.failure is None or failure.anew:
            self.failure = failure
        else:
            self.run.log(f"finally: {failure.words()}", self.path)
