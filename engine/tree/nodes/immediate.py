"""Steps that take no time: log, notify, set, require, fail."""

import asyncio
from collections import ChainMap
from collections.abc import Iterator, Mapping
from functools import partial
from itertools import count
from typing import Any

from py_trees.common import Status

from ....schemas.journal import Computed, StepEnded
from ....system.tasks import spawn
from ...journal.encode import decode, encode
from ...language.expression import ExpressionError, Pending
from ...language.own_functions import OwnFunction
from ...language.value import Value, as_text
from ...run.frame import Scope
from ...run.function_calls import FunctionFailed
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
        names = self.scope.frame.names
        return self.run.names(names, self.path) if self.run.asks_clocks else names

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
            if self.replaying:
                return self.fail(came_to_here(self.path))
            text = as_text(self.text.evaluate(self.names))
            self.run.record(StepEnded(path=self.path, fate="succeeded", message=text))
            self.run.log(text, self.path)
        return Status.SUCCESS


class Notify(Immediate):
    """A message to people; written once across engine sessions, as far as an engine can know."""

    def __init__(
        self, segment: str, run: Run, scope: Scope, text: Value, picture: Value | None
    ) -> None:
        super().__init__(segment, run, scope)
        self.text = text
        self.picture = picture

    def act(self) -> Status:
        if self.path not in self.run.past.steps:
            if self.replaying:
                return self.fail(came_to_here(self.path))
            text = as_text(self.text.evaluate(self.names))
            picture = "" if self.picture is None else as_text(self.picture.evaluate(self.names))
            self.run.record(StepEnded(path=self.path, fate="succeeded", message=text))
            self.run.log(text, self.path)
            self.run.notify(text, picture)
        return Status.SUCCESS


class SetNames(Immediate):
    """Gives names their values, all from the values before.

    Functions of the protocol's own are called one after the other, each in a process of its own; what
    they gave is in the journal, so that a resumed run does not call them again.
    """

    def __init__(
        self, segment: str, run: Run, scope: Scope, values: Mapping[str, Value],
        functions: Mapping[str, OwnFunction], limit_s: float,
    ) -> None:  # fmt: skip
        super().__init__(segment, run, scope)
        self.values = values
        self.functions = functions
        self.limit_s = limit_s
        self.calling: asyncio.Task[Any] | None = None

    def act(self) -> Status:
        if self.calling is not None:
            if not self.calling.done():
                return Status.RUNNING
            self.calling, called = None, self.calling
            if (why := called.result()) is not None:
                return self.fail(Failure("FunctionFailed", why, step=self.path))
        frame = self.scope.frame
        names = self._names()
        try:
            new = {name: value.evaluate(names) for name, value in self.values.items()}
        except Pending:
            if self.replaying:
                return self.fail(came_to_here(self.path))
            return Status.RUNNING
        for name, value in new.items():
            frame.assign(name, value)
        self.result = new
        if self.run.is_heard("step"):
            self.run.tell("step", self.path, "set", values=new)
        return Status.SUCCESS

    def terminate(self, new_status: Status) -> None:
        if self.calling is not None and new_status == Status.INVALID:
            self.calling.cancel()
            self.calling = None

    def _names(self) -> Mapping[str, Any]:
        if not self.functions:
            return self.names
        asked = count(1)
        own = {
            f"{name}()": partial(self._call, function, asked)
            for name, function in self.functions.items()
        }
        return ChainMap(own, self.names)  # type: ignore[arg-type]

    def _call(self, function: OwnFunction, asked: Iterator[int], *args: Any, **named: Any) -> Any:
        path = f"{self.path}/{function.name}:{next(asked)}"
        known = self.run.history.past.computed
        if path in known:
            return decode(known[path])
        given = function.given(args, named)
        if not self.replaying:
            work = self._called(function, given, path)
            self.calling = spawn(f"call {function.name}", work)
        raise Pending

    async def _called(self, function: OwnFunction, given: dict[str, Any], path: str) -> str | None:
        """Call a function, and put what it gave into the journal; why not, if it failed."""
        self.run.calling.append(function.name)
        try:
            value = await self.run.call(function, given, self.limit_s)
            self.run.record(Computed(path=path, value=encode(value)))
            return None
        except FunctionFailed as fault:
            return str(fault)
        except OSError as fault:
            return f"{function.name}: no process could be started: {fault.strerror}"
        finally:
            self.run.calling.remove(function.name)
            self.run.requests.again()
            self.run.questions.changed()


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
        text = as_text(self.text.evaluate(self.names))
        return self.fail(Failure("Failed", text, step=self.path))
