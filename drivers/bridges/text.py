"""Any line protocol over TCP, UDP, WebSocket or a serial port: what is sent, and patterns of answers.

See docs/how-to/instruments-in-yaml.md.
"""

from collections.abc import Iterator
from json import dumps
from string import Formatter
from typing import Any, ClassVar

from pydantic import Field, field_validator, model_validator

from ...schemas.contract import Action, Name
from ..driver import ActionFailed, GoalContext
from .answers import NUMBER_ERRORS, OWN, PART, BadAnswer
from .bridge import Values
from .config import Pattern, chosen
from .data import answer_values
from .line_bridge import LineAction, LineBridge, LineBridgeConfig
from .lines import Exchange, NoAnswer
from .template import fill, filled, texts


class TextAction(LineAction):
    """`send`, then an `answer`, then for what takes time a line that it is `done`; data is sent as JSON."""

    send: str | dict[str, Any] | list[str | Exchange] | None = None
    done: Pattern | None = None

    @model_validator(mode="after")
    def _does_something(self) -> "TextAction":
        if any(one.send is None for one in self.sends):
            raise ValueError("in `send`, say what is sent: {after: OK, send: GO}")
        if self.send is None and self.answer is None:
            raise ValueError(
                "it needs `send`, or the `answer` of an instrument that speaks by itself"
            )
        return self

    @property
    def sends(self) -> list[Exchange]:
        """The lines, in order, and what is waited for before each; the answer is that to the last."""
        whole = self.send if isinstance(self.send, list) else [self.send]
        return [
            one if isinstance(one, Exchange) else Exchange(send=one if isinstance(one, str) else "")
            for one in whole
            if one is not None
        ]

    def used(self) -> Iterator[tuple[str, str]]:
        yield from (("send", one.send) for one in self.sends if one.send is not None)
        if isinstance(self.send, dict):
            yield from texts("send", self.send)


class TextConfig(LineBridgeConfig):
    """The config of `driver: text`; `hello` asks who it is."""

    kinds = (*LineBridgeConfig.kinds, "ws")
    own_keys = ("at", *OWN)
    own_errors = {  # type: ignore[assignment] # noqa: RUF012
        **NUMBER_ERRORS,
        "DeviceError": ("unknown", "The instrument reports an error that the lab does not name"),
    }

    hello: TextAction | None = None

    def known(self) -> dict[str, Any]:
        return self.hello.returns if self.hello is not None else {}

    error_query: TextAction | None = None

    @model_validator(mode="after")
    def _answers_before_its_prompt(self) -> "TextConfig":
        for name, said in self.actions.items():
            if self.prompt and said.answer == "":
                raise ValueError(f"{name}: leave out its empty `answer`; the prompt ends it")
        return self

    @field_validator("error_query")
    @classmethod
    def _asks(cls, value: TextAction | None) -> TextAction | None:
        if value is not None and (not isinstance(value.send, str) or value.answer is None):
            raise ValueError(
                'say what is asked, and which `answer` means no error: {send: "ERR?", answer: "0"}'
            )
        return value

    actions: dict[Name, TextAction] = Field(min_length=1)


class Text(LineBridge):
    """Implements whichever contract its lab says or names."""

    config_model: ClassVar = TextConfig

    async def identify(self, timeout_s: float) -> None:
        hello: TextAction | None = self.config.hello
        if hello is None:
            return
        try:
            await self.greet(hello)
        except (NoAnswer, BadAnswer) as fault:
            said = f"{self.lines}: {fault}"
            if isinstance(hello.send, str) and f"answered {hello.send!r}"[:-1] in said:
                raise OSError(f"{said}; it repeats what it hears: say `echo: true`") from fault
            other = "; is another device there, or does it use another terminator or baud rate?"
            raise OSError(said if PART in said else said + other) from fault
        except ActionFailed as failure:
            raise OSError(failure.message) from failure
        sent = {text for said in self._said.values() for _, text in said.used()}
        keys = {name for text in sent for _, name, _, _ in Formatter().parse(text)}
        self.versions = {name: str(value) for name, value in self.known.items() if name not in keys}

    def answers(self, said: TextAction) -> bool:
        asked = chosen(said, ("answer", "done", "block", "until")) or said.returns
        habits = self.config.echo or self.config.prompt or self.config.error_query
        return bool(asked or habits)

    async def perform(
        self, said: TextAction, action: Action, values: Values, goal: GoalContext
    ) -> Values:
        params, values = self.params(said, action), self.known | values
        decimal = self.config.decimal
        lines = [
            (one.after, fill(one.send or "", values, params, goal.id, decimal))
            for one in said.sends
        ]
        if isinstance(said.send, dict):
            lines = [(None, dumps(filled(said.send, values, params, goal.id)))]
        self.out = 0
        last = ""
        for number, (after, text) in enumerate(lines):
            if after is not None:
                await self._until_said(after, last, said)
            elif number:
                self.refuse(last, await self.lines.finish(last, self.timeout_s(said)), said)
            await self.put(text)
            last = text
        result: Values = {}
        answered = chosen(said, ("answer", "block")) or action.returns.get("properties")
        if answered:
            if not lines:
                self.lines.forget()
            result = await self.answered(last, said, action, values, goal)
        else:
            self.refuse(last, await self.lines.finish(last, self.timeout_s(said)), said)
            if said.done is None:
                await self.listen_for_errors(last, said)
        if said.done is not None:
            self.out += bool(answered)  # it has been accepted: what is reported now is no refusal
            await self._until_said(said.done, last, said)
        await self._ask_for_errors(last, goal)
        return result

    def read(self, text: str, returns: Values, wanted: Any) -> Values:
        """Where the lab says `at`, the answer is JSON, or what its pattern picks is."""
        json = any("at" in schema for schema in returns.values())
        return answer_values(text, returns, wanted, json=json, decimal=self.config.decimal)

    async def _ask_for_errors(self, sent: str, goal: GoalContext) -> None:
        """An instrument that keeps its errors for whoever asks; an `answer` means that there is none."""
        asked: TextAction | None = self.config.error_query
        if asked is None or goal.id in ("hello", "abort"):
            return
        text = str(asked.send)
        await self.lines.send(text)
        told = await self.lines.answer(text, self.timeout_s(asked))
        self.refuse(sent, told, asked)
        wanted = self.pattern(asked.answer or "")
        if not (wanted.fullmatch(told) or wanted.fullmatch(told.strip())):
            words = f"{self.place.device} was sent {sent!r} and reports {told[:80]!r}"
            raise ActionFailed("DeviceError", words, "unknown")

    async def _until_said(self, words: str, sent: str, said: TextAction) -> None:
        """Pass over lines until one that says so; raises NoAnswer, or ActionFailed for an error."""
        wanted = self.pattern(words)
        while True:
            try:
                line = await self.lines.next_line(self.timeout_s(said))
            except NoAnswer as fault:
                raise NoAnswer(f"it was sent {sent!r} and is not done: {fault}") from fault
            if wanted.search(line):
                return
            self.refuse(sent, line, said)
