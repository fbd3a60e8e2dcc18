"""Steps that take no time: log, set, require, fail."""

from collections.abc import Mapping
from typing import Any

from py_trees.common import Status

from ....schemas.journal import StepEnded
from ...journal.encode import encode
from ...language.expression import ExpressionError
from ...language.value import Value
from ...run.frame import Scope
from ...run.run import Run
from .failure import Failure
from .node import Node
from .replay_failed import came_to_here


class Immediate(Node):
    """Does its work in one update; an error in an expression is a failure of the step."""

    def __init__(self, segment: str, run: Run, scope: Scope) -> None:
        super().__init__(segment, run)
        self.scope = scope

    @property
    def path(self) -> str:
        """The current path of this step."""
        return f"{self.scope.frame.path}/{self.name}"

    @property
    def names(self) -> Mapping[str, Any]:
        """The names that its expressions may use."""
        return self.run.names(self.scope.frame.names, self.path)

    def update(self) -> Status:
        try:
            return self.act()
        except ExpressionError as fault:
            return self.fail(Failure("Expression", str(fault), step=self.path))

    def act(self) -> Status:
        """What the step does."""
        raise NotImplementedError


class Log(Immediate):
    """A line for the screen and the journal, written once even across several engine sessions."""

    def __init__(self, segment: str, run: Run, scope: Scope, text: Value) -> None:
        super().__init__(segment, run, scope)
        self.text = text

    def act(self) -> Status:
        if self.path not in self.run.past.steps:
            if self.run.replaying:
                return self.fail(came_to_here(self.path))
            text = str(self.text.evaluate(self.names))
            self.run.record(StepEnded(path=self.path, fate="succeeded", message=text))
            self.run.log(text, self.path)
        return Status.SUCCESS


class SetNames(Immediate):
    """Gives names their values, all from the values before."""

    def __init__(self, segment: str, run: Run, scope: Scope, values: Mapping[str, Value]) -> None:
        super().__init__(segment, run, scope)
        self.values = values

    def act(self) -> Status:
        frame = self.scope.frame
        names = self.names
        new = {name: value.evaluate(names) for name, value in self.values.items()}
        for name, value in new.items():
            frame.assign(name, value)
        self.result = new
        self.run.tell("step", self.path, "set", values=encode(new))
        return Status.SUCCESS


class Require(Immediate):
    """Fails unless its expression is true."""

    def __init__(self, segment: str, run: Run, scope: Scope, value: Value, text: str) -> None:
        super().__init__(segment, run, scope)
        self.value = value
        self.text = text

    def act(self) -> Status:
        if self.value.evaluate(self.names):
            return Status.SUCCESS
        if self.run.asks_clocks:  # tried again, it asks them again
            self.run.record(StepEnded(path=self.path, fate="failed"))
        return self.fail(Failure("Required", f"{self.text} is not true", step=self.path))


class Fail(Immediate):
    """Fails with the author's message."""

    def __init__(self, segment: str, run: Run, scope: Scope, text: Value) -> None:
        super().__init__(segment, run, scope)
        self.text = text

    def act(self) -> Status:
        text = str(self.text.evaluate(self.names))
        return self.fail(Failure("Failed", text, step=self.path))
