"""Any line protocol over TCP, UDP or a serial port: what is sent, and patterns of what is answered.

See docs/how-to/instruments-in-yaml.md.
"""

import contextlib
from collections.abc import Iterator
from typing import ClassVar

from pydantic import Field, field_validator, model_validator

from ...schemas.contract import Action, Name
from ...schemas.patterns import regular_expression
from ..driver import ActionFailed, GoalContext
from .answers import BadAnswer
from .bridge import Values
from .config import pattern
from .line_bridge import LineAction, LineBridge, LineBridgeConfig
from .lines import NoAnswer
from .template import fill

REFUSED_S = 0.2
"""How long an error may take to come after a command that has no answer."""


class TextAction(LineAction):
    """`send`, then an `answer`, then for what takes time a line that it is `done`."""

    send: str | list[str] | None = None
    done: str | None = None

    @field_validator("done")
    @classmethod
    def _is_done(cls, value: str | None) -> str | None:
        return pattern(value)

    @model_validator(mode="after")
    def _does_something(self) -> "TextAction":
        if self.send is None and self.answer is None:
            raise ValueError(
                "it needs `send`, or the `answer` of an instrument that speaks by itself"
            )
        return self

    @property
    def sends(self) -> list[str]:
        """The lines, in order; the answer is that to the last."""
        return [self.send] if isinstance(self.send, str) else list(self.send or [])

    def used(self) -> Iterator[tuple[str, str]]:
        yield from (("send", text) for text in self.sends)


class TextConfig(LineBridgeConfig):
    """The config of `driver: text`; `hello` asks who it is."""

    hello: TextAction | None = None
    actions: dict[Name, TextAction] = Field(min_length=1)
    status: list[str] = Field(default_factory=list)


class Text(LineBridge):
    """Implements whichever contract its lab says or names."""

    config_model: ClassVar = TextConfig

    async def identify(self, timeout_s: float) -> None:
        hello: TextAction | None = self.config.hello
        if hello is None:
            return
        action = Action(returns={"properties": dict(hello.returns)})
        try:
            told = await self.perform(hello, action, {}, GoalContext("hello"))
        except (NoAnswer, BadAnswer) as fault:
            await self.drop()
            raise OSError(
                f"{self.lines}: {fault}; is another device there, or are its terminator or baud rate "
                f"others?"
            ) from fault
        except ActionFailed as failure:
            await self.drop()
            raise OSError(failure.message) from failure
        self.versions = {name: str(value) for name, value in told.items()}

    def answers(self, said: TextAction) -> bool:
        listened = (said.answer, said.done, self.config.prompt, said.until)
        return bool(said.returns or self.config.echo or any(one is not None for one in listened))

    async def perform(
        self, said: TextAction, action: Action, values: Values, goal: GoalContext
    ) -> Values:
        params = action.param_schemas()
        decimal = self.config.decimal
        texts = [fill(text, values, params, goal.id, decimal) for text in said.sends]
        self.out = 0
        for text in texts:
            await self.put(text)
            if text is not texts[-1]:
                self.refuse(text, await self.lines.finish(text, self.timeout_s(said)), said)
        last = texts[-1] if texts else ""
        result: Values = {}
        answered = said.answer is not None or bool(action.returns.get("properties"))
        if answered:
            if not texts:
                self.lines.channel.received.clear()
            result = await self.heard(last, said, action, goal)
        else:
            self.refuse(last, await self.lines.finish(last, self.timeout_s(said)), said)
            await self._listen_for_errors(last, said)
        if said.done is not None:
            self.out += answered  # it has been accepted: what is reported now is no refusal
            await self._until_done(said, last)
        return result

    async def _listen_for_errors(self, sent: str, said: TextAction) -> None:
        """A command without an answer may be refused all the same."""
        errors = {**self.config.errors, **said.errors}.values()
        if said.done is None and any(error.answer is not None for error in errors):
            with contextlib.suppress(NoAnswer):
                while True:
                    self.refuse(sent, await self.lines.next_line(REFUSED_S), said)

    async def _until_done(self, said: TextAction, sent: str) -> None:
        wanted = regular_expression(said.done or "")
        while True:
            try:
                line = await self.lines.next_line(self.timeout_s(said))
            except NoAnswer as fault:
                raise NoAnswer(f"it was sent {sent!r} and is not done: {fault}") from fault
            if wanted.search(line):
                return
            self.refuse(sent, line, said)
